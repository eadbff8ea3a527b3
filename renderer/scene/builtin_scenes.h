#pragma once
#include <span>
#include <string_view>

namespace photond {

struct Scene;

/// Names of the scenes made in code (protocol.md, "Built-in scenes"), each with a camera named "camera".
std::span<const std::string_view> builtin_scene_names();

/// Names of the scenes of one of kSceneFamilies; throws ErrorCode::UnknownName for an unknown family.
std::span<const std::string_view> builtin_scene_names(std::string_view family);

/// Whether there is a built-in scene of that name, in whatever family.
bool is_builtin_scene(std::string_view name);

/// Makes one; throws ErrorCode::NotFound for an unknown name.
Scene make_builtin_scene(std::string_view name);

}  // namespace photond
