#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "renderer/scene/scene.h"

namespace photond {

/// The scene object of protocol.md without its id.
nlohmann::json scene_summary(const Scene& scene, const std::string& name, bool builtin);

}  // namespace photond
