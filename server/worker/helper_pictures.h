#pragma once
// Quick pictures of a scene, to recognise it by and to choose a view of it. Each takes and gives what worker_messages.h
// says.

#include <nlohmann/json.hpp>

#include "server/worker/scene_cache.h"

namespace photond {

/// PNG of the scene by its first camera, else framed on its bounds. `memory_bytes` bounds scene and film; the scene
/// stays in `scenes`. A scene that brings no light is shown under a white sky.
nlohmann::json thumbnail(const nlohmann::json& message, uint64_t memory_bytes, SceneCache& scenes);

/// The same by whatever camera, in the size and with the passes asked for. Throws ErrorCode::UnknownName for a camera
/// that the scene has not.
nlohmann::json preview_scene(const nlohmann::json& message, uint64_t memory_bytes, SceneCache& scenes);

}  // namespace photond
