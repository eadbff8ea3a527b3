#pragma once
// What cannot be done now but in a while that can be told.

#include "protocol/error.h"

namespace photond {

class TryLater : public Error {
public:
    TryLater(const std::string& detail, int after_seconds)
        : Error(ErrorCode::Unavailable, detail), retry_after_seconds(after_seconds) {}

    const int retry_after_seconds;
};

}  // namespace photond
