#pragma once
// What is heard of a running attempt and told of its job: progress, curve, films saved on the way.

#include <chrono>
#include <nlohmann/json.hpp>

#include "server/service/attempt_records.h"
#include "server/service/running_attempt.h"
#include "server/service/service_core.h"

namespace photond {

inline constexpr auto kProgressInterval = std::chrono::milliseconds(250);  // four events a second for each job

/// All under the lock.
class AttemptProgress {
public:
    AttemptProgress(ServiceCore& core, AttemptRecords& records) : core_(core), records_(records) {}

    /// The messages of a worker, by their types.
    void progress(RunningAttempt& attempt, const nlohmann::json& message);
    void curve(RunningAttempt& attempt, const nlohmann::json& message);
    void film_saved(RunningAttempt& attempt, const nlohmann::json& message);
    /// Tells points that no event has told, unless the last ones were told just now.
    void publish_curve(RunningAttempt& attempt);

private:
    void publish_progress(const RunningAttempt& attempt);

    ServiceCore& core_;
    AttemptRecords& records_;
};

}  // namespace photond
