#pragma once
// Quick pictures of a scene, to recognise it by and to choose a view of it: few paths a pixel, and a filter over the
// light that surfaces scatter (renderer/gbuffer/edge_avoiding_filter.h). No result of a job is filtered.

#include <cstdint>

#include "protocol/helper_messages.h"
#include "server/worker/scene_cache.h"

namespace photond {

/// PNG of the scene by its first camera, else framed on its bounds. `memory_bytes` bounds scene and film; the scene
/// stays in `scenes`. A scene that brings no light is shown under a white sky.
void thumbnail(const ThumbnailRequest& request, uint64_t memory_bytes, SceneCache& scenes);

/// The same by whatever camera, in the size and with the passes asked for. Throws ErrorCode::UnknownName for a camera
/// that the scene has not.
PreviewSceneReply preview_scene(const PreviewSceneRequest& request, uint64_t memory_bytes, SceneCache& scenes);

}  // namespace photond
