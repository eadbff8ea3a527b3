#pragma once
#include <span>
#include <string_view>

#include "renderer/scene/scene.h"

namespace photond {

/// Names of the scenes made in code (protocol.md, "Built-in scenes"), each with a camera named "camera".
std::span<const std::string_view> builtin_scene_names();

/// Makes one; throws ErrorCode::NotFound for an unknown name.
Scene make_builtin_scene(std::string_view name);

}  // namespace photond
