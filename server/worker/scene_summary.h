#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace photond {

struct Scene;

/// The scene as on the wire (protocol.md, "Scene"), without its id.
nlohmann::json scene_summary(const Scene& scene, const std::string& name, bool builtin);

}  // namespace photond
