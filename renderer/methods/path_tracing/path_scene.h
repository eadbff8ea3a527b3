#pragma once
// What all tiles and passes of one path-traced render share.

#include "renderer/eye/eye_scene.h"
#include "renderer/methods/path_tracing/path_tracing.h"

namespace photond {

struct PathTracingScene : EyeScene {
    PathTracingScene(const RenderContext& context, const PathTracingParams& params)
        : EyeScene(context, params.sampler, params.max_scatterings()), roulette_start(params.roulette_start) {}

    const uint32_t roulette_start;
};

}  // namespace photond
