#pragma once
// How an error falls as passes double.

#include "tests/support/render.h"
#include "tests/support/statistics.h"

namespace photond::test {

/// One run of `settings.passes` = first 2^k passes gives, for each n = first, 2 first ... settings.passes, as many
/// films of n consecutive passes as fit: the mean of their errors, error(film). All n have so seen the same paths.
template <class M, class Error>
std::vector<double> errors_of_doubled_passes(const Scene& scene, const RenderSettingsOf<M>& settings, uint32_t first,
                                             const Error& error) {
    std::vector<uint32_t> lengths;
    for (uint32_t n = first; n <= settings.passes; n *= 2) lengths.push_back(n);
    std::vector<Film> films(lengths.size(), Film(settings.size, settings.layers));
    std::vector<RunningMean> errors(lengths.size());
    run_passes(scene, settings, [&](M& method, uint32_t) {
        for (size_t i = 0; i < lengths.size(); ++i) {
            method.resolve(films[i]);
            if (films[i].passes() < lengths[i]) continue;
            errors[i].add(error(films[i]));
            films[i] = Film(settings.size, settings.layers);
        }
    });
    std::vector<double> means;
    for (const RunningMean& mean : errors) means.push_back(mean.mean());
    return means;
}

}  // namespace photond::test
