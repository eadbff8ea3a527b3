#pragma once
// What is heard of a running attempt and told of its job: progress, curve, films saved on the way.

#include <chrono>

#include "protocol/worker_messages.h"
#include "server/service/attempt_records.h"
#include "server/service/running_attempt.h"
#include "server/service/service_core.h"

namespace photond {

inline constexpr auto kProgressInterval = std::chrono::milliseconds(250);  // four events a second for each job

/// All under the lock.
class AttemptProgress {
public:
    AttemptProgress(ServiceCore& core, AttemptRecords& records) : core_(core), records_(records) {}

    void progress(RunningAttempt& attempt, const ProgressMessage& told);
    void curve(RunningAttempt& attempt, const CurveMessage& told);
    void film_saved(RunningAttempt& attempt, const FilmSavedMessage& told);
    /// Tells what no event has told, unless the last of its kind was told just now.
    void publish_untold(RunningAttempt& attempt);

private:
    void publish_progress(RunningAttempt& attempt);
    void publish_curve(RunningAttempt& attempt);

    ServiceCore& core_;
    AttemptRecords& records_;
};

}  // namespace photond
