#include "server/comparisons/pareto.h"

#include <algorithm>
#include <set>

namespace photond {
namespace {

bool dominates(const std::vector<TimedError>& curve, const TimedError& point) {
    for (const TimedError& other : curve) {
        if (other.seconds >= point.seconds) break;
        if (other.error <= point.error) return true;
    }
    const auto then = error_at_time(curve, point.seconds);
    return then && then->error < point.error;
}

}  // namespace

std::vector<bool> pareto_front(std::span<const std::vector<TimedError>> curves) {
    std::set<double> times;
    for (const auto& curve : curves)
        for (const TimedError& point : curve) times.insert(point.seconds);
    std::vector<bool> on_front(curves.size(), false);
    for (size_t i = 0; i < curves.size(); ++i) {
        const auto undominated = [&](double seconds) {
            const auto error = error_at_time(curves[i], seconds);
            if (!error) return false;
            for (size_t j = 0; j < curves.size(); ++j)
                if (j != i && dominates(curves[j], *error)) return false;
            return true;
        };
        on_front[i] = std::any_of(times.begin(), times.end(), undominated);
    }
    return on_front;
}

}  // namespace photond
