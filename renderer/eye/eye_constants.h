#pragma once
// The eye on the device: its tiles, and its buffer's contents.

#include <algorithm>

#include "renderer/eye/eye_shared.h"
#include "renderer/frame/render_context.h"

namespace photond {

inline constexpr uint32_t kEyeTilePixels = EYE_TILE * EYE_TILE;
/// Tiles of EYE_TILE pixels a side that cover an image.
constexpr uint32_t eye_tile_count(Size2 size) {
    return (size.width + EYE_TILE - 1) / EYE_TILE * ((size.height + EYE_TILE - 1) / EYE_TILE);
}

/// Of so many tiles, how many may be under way at once where so many paths may: one at least.
constexpr uint32_t eye_tiles_at_once(uint32_t tiles, uint32_t paths) {
    return std::clamp(paths / kEyeTilePixels, 1u, std::max(tiles, 1u));
}

/// `roulette_start`: surface interactions after which Russian roulette may end a path.
gpu::EyeConstants make_eye_constants(const View& view, uint32_t max_scatterings, uint32_t roulette_start);

}  // namespace photond
