#pragma once
// What cannot be done now but in a while that can be told.

#include "protocol/error.h"

namespace photond {

class TryLater : public Error {
public:
    TryLater(const std::string& detail, int after_seconds, bool under_way = false)
        : Error(ErrorCode::Unavailable, detail), retry_after_seconds(after_seconds), under_way(under_way) {}

    const int retry_after_seconds;
    const bool under_way;  // what was asked for is being made meanwhile
};

/// Whether what failed so may succeed when it is tried again without any change: a job renders meanwhile, a helper is
/// started anew, or the disk is full.
inline bool may_pass(ErrorCode code) {
    return code == ErrorCode::Unavailable || code == ErrorCode::WorkerLost || code == ErrorCode::NoSpace;
}

}  // namespace photond
