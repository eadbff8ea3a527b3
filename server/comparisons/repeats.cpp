#include "server/comparisons/repeats.h"

#include <algorithm>
#include <optional>

namespace photond {

size_t run_that_counts(std::span<const MeasuredJob> runs) {
    const auto share = [&](size_t run) { return runs[run].loss ? runs[run].loss->share : 1.0; };
    std::optional<size_t> best;
    for (size_t run = 0; run < runs.size(); ++run)
        if (runs[run].succeeded() && (!best || share(run) > share(*best))) best = run;
    return best.value_or(0);
}

bool is_to_be_repeated(std::span<const MeasuredJob> runs, size_t most) {
    return runs.size() <= most && runs.back().succeeded() &&
           std::all_of(runs.begin(), runs.end(),
                       [](const MeasuredJob& run) { return run.is_over() && (!run.succeeded() || run.loss); });
}

}  // namespace photond
