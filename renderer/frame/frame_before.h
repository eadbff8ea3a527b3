#pragma once
// What a frame of an animation is told of the one before it.

#include <memory>
#include <string>

#include "renderer/scene/past_pose.h"

namespace photond {

struct FrameBefore {
    std::string left;  // Method::left_to_next() of it
    /// How the scene lay in it; null where it is not known: what moves is then taken to be new.
    std::shared_ptr<const PastPose> pose;
};

}  // namespace photond
