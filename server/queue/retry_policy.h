#pragma once
// What becomes of a job whose attempt ended without a result (protocol.md, "The daemon").

#include <optional>

#include "protocol/error.h"

namespace photond {

inline constexpr int kFurtherAttemptsAfterLoss = 2;   // lost through no fault of the job's
inline constexpr int kFurtherAttemptsAfterCrash = 1;  // crashed by a signal of its own, or its GPU was lost

enum class AttemptEnd : uint8_t {
    Lost,         // the daemon died, or the worker was killed from outside
    Crashed,      // the worker crashed, or hung, on this job
    DeviceLost,   // the GPU stopped answering
    OutOfMemory,  // passed its memory limit
    NoSpace,      // passed its file size limit
    TimedOut,     // passed its deadline
};

/// Why the job fails now; empty: it goes back to the queue. The counts are those since the job last saved a film of
/// more passes, the attempt that has just ended included; lost devices are among the crashes.
std::optional<ErrorCode> failure_after(AttemptEnd end, int losses, int crashes);

}  // namespace photond
