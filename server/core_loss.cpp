#include "server/core_loss.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "server/comparisons/report_text.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr double kLeastNamed = 0.01;  // of what was lost
constexpr double kLeastSaid = 0.1;    // likewise, in the sentence

std::string spoken(const std::string& who) {
    if (who == "helper") return "our helper";
    if (who == "pictures") return "pictures drawn beside it";
    return who == "photond" ? "photond itself" : who;
}

std::vector<LostTo> shared_out(const CoreUse& use, const ProcessorSeconds& ours) {
    const double lost = use.lost_seconds.value_or(0);
    const double of_ours = std::accumulate(ours.begin(), ours.end(), 0.0,
                                           [](double sum, const auto& taken) { return sum + taken.second; });
    // Ours are read from an attempt's beginning to its end, which is more than its clock.
    const double outside = std::max(use.host_busy_outside_seconds.value_or(of_ours + lost), of_ours);
    std::vector<LostTo> to;
    const auto add = [&](const std::string& who, double taken) {
        const double seconds = outside > 0 ? lost * taken / outside : 0;
        if (seconds > kLeastNamed * lost) to.push_back({who, seconds});
    };
    for (const auto& [who, taken] : ours) add(who, taken);
    add("others", outside - of_ours);
    std::stable_sort(to.begin(), to.end(), [](const LostTo& a, const LostTo& b) { return a.seconds > b.seconds; });
    return to;
}

/// Whose taking is worth a word.
std::string names_of(const CoreLoss& loss) {
    std::vector<std::string> named;
    const bool several = loss.to.size() > 1 && loss.to[1].seconds >= kLeastSaid * loss.seconds;
    for (const LostTo& taker : loss.to)
        if (named.empty() || taker.seconds >= kLeastSaid * loss.seconds)
            named.push_back(spoken(taker.who) + (several ? " (" + short_seconds(taker.seconds) + ")" : ""));
    std::string names;
    for (size_t i = 0; i < named.size(); ++i)
        names += (i == 0 ? "" : i + 1 == named.size() ? " and " : ", ") + named[i];
    return names;
}

std::string part_of(const CoreLoss& loss) {
    return short_seconds(loss.seconds) + " of its processor time (" +
           std::to_string(std::lround(100 * (1 - loss.share))) + " %)";
}

}  // namespace

std::optional<CoreLoss> CoreLoss::of(const CoreUse& use, const ProcessorSeconds& ours) {
    if (!use.share || !use.lost_seconds || *use.share >= kUndisturbedShare || *use.lost_seconds < kLeastLoss_s)
        return std::nullopt;
    return CoreLoss{*use.share, *use.lost_seconds, use.clock_lost_seconds.value_or(*use.lost_seconds),
                    shared_out(use, ours)};
}

std::optional<CoreLoss> CoreLoss::of_statistics(const json& statistics) {
    const json shared = statistics.is_object() ? statistics.value("shared", json()) : json();
    if (!shared.is_object()) return std::nullopt;
    CoreLoss loss{shared.at("share"), shared.at("lost_seconds"), shared.at("clock_seconds"), {}};
    for (const json& taker : shared.at("to")) loss.to.push_back({taker.at("who"), taker.at("seconds")});
    return loss;
}

std::string CoreLoss::what() const { return part_of(*this) + " to " + names_of(*this); }

std::string CoreLoss::warning() const {
    return part_of(*this) + " were lost to " + names_of(*this) + ": its clock cannot be compared; run it again.";
}

json to_json(const std::optional<CoreLoss>& loss) {
    if (!loss) return nullptr;
    json list = json::array();
    for (const LostTo& taker : loss->to) list.push_back({{"who", taker.who}, {"seconds", taker.seconds}});
    return {{"share", loss->share},
            {"lost_seconds", loss->seconds},
            {"clock_seconds", loss->clock_seconds},
            {"to", std::move(list)},
            {"warning", loss->warning()}};
}

}  // namespace photond
