#pragma once
// What a sequence is at a moment, as it is read under the lock, and as clients see it, which takes longer to write.

#include <array>
#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "server/store/store.h"

namespace photond {

struct SequenceView {
    ComparisonRow row;
    std::array<int64_t, std::size(kJobStates)> jobs{};  // how many are in each state
    double begun_progress = 0;                          // of those that are not over, together
    bool has_begun = false;                             // one of them, or a reference made for them
    std::optional<int64_t> started_ms, finished_ms;     // the first that began, the last that ended
    std::optional<std::vector<FrameRow>> frames;        // where they were asked for

    JobState state() const;
    nlohmann::json object() const;
};

}  // namespace photond
