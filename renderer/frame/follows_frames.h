#pragma once
// A method that keeps something of its own from frame to frame of an animation.

#include <string>
#include <utility>

#include "renderer/frame/frame_before.h"

namespace photond {

/// `Base`: Method or DeviceMethod. `Frames`: what is kept, with follow(), go_on_from(), state() and left_to_next() as
/// Method has them.
template <class Base, class Frames>
class FollowsFrames : public Base {
public:
    void follow(FrameBefore before) override { frames_.follow(std::move(before)); }
    void go_on_from(const std::string& state) override { frames_.go_on_from(state); }
    std::string state() const override { return frames_.state(); }
    std::string left_to_next() const override { return frames_.left_to_next(); }

protected:
    template <class... Arguments>
    explicit FollowsFrames(const Arguments&... arguments) : frames_(arguments...) {}

    Frames frames_;
};

}  // namespace photond
