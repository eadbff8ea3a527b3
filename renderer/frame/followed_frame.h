#pragma once
// Which frame of an animation a method's passes follow, for whoever goes on with them.

#include <string>

#include "protocol/error.h"
#include "renderer/core/sha256.h"

namespace photond {

/// Passes of which some followed one frame and some another would make a film of neither.
class FollowedFrame {
public:
    /// `left`: Method::left_to_next() of it.
    void follow(const std::string& left) { sha256_ = sha256_hex(left.data(), left.size()); }
    /// As Method::go_on_from().
    void go_on_from(const std::string& state) const {
        if (state != sha256_) throw Error(ErrorCode::Conflict, "its passes do not follow the frame before");
    }
    /// As Method::state(). Empty: they follow none.
    const std::string& state() const { return sha256_; }

private:
    std::string sha256_;
};

}  // namespace photond
