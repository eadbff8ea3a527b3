#pragma once
// The eye on the device: its buffer's contents.

#include "renderer/eye/eye_shared.h"
#include "renderer/frame/render_context.h"

namespace photond {

/// `roulette_start`: surface interactions after which Russian roulette may end a path.
gpu::EyeConstants make_eye_constants(const View& view, uint32_t max_scatterings, uint32_t roulette_start);

}  // namespace photond
