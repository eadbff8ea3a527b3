#include "server/queue/retry_policy.h"

namespace photond {

std::optional<ErrorCode> failure_after(AttemptEnd end, int losses, int crashes) {
    switch (end) {
        case AttemptEnd::Lost:
            if (losses > kFurtherAttemptsAfterLoss) return ErrorCode::WorkerLost;
            return std::nullopt;
        case AttemptEnd::Crashed:
            if (crashes > kFurtherAttemptsAfterCrash) return ErrorCode::WorkerCrashed;
            return std::nullopt;
        case AttemptEnd::DeviceLost:
            if (crashes > kFurtherAttemptsAfterCrash) return ErrorCode::DeviceLost;
            return std::nullopt;
        case AttemptEnd::OutOfMemory: return ErrorCode::OutOfMemory;
        case AttemptEnd::NoSpace: return ErrorCode::NoSpace;
        case AttemptEnd::TimedOut: return ErrorCode::TimedOut;
    }
    return ErrorCode::Internal;
}

}  // namespace photond
