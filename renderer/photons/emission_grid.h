#pragma once
// Bins of primary sample space: the two unit squares a light path starts with, cut into cells.

#include "renderer/core/geometry.h"

namespace photond {

struct Scene;

/// How the squares of one light are cut.
struct EmissionResolution {
    uint32_t places;      // u_position: cells along each side
    uint32_t directions;  // u_direction
    uint32_t bins() const { return places * places * directions * directions; }
};

/// 4^levels bins. Points and spots are cut by directions alone, directional lights by places. Where both matter, a
/// light seen from afar is to be about as wide as a bin of directions: both blur what is seen by as much. `light` as in
/// EmissionSampler.
EmissionResolution emission_resolution(const Scene& scene, uint32_t light, int levels);

/// u in that cell of a square of count.x x count.y; stays below 1.
inline vec2 into_cell(const uvec2& cell, const uvec2& count, const vec2& u) {
    constexpr float kBelowOne = 0x1.fffffep-1f;
    return glm::min((vec2(cell) + u) * (1.0f / vec2(count)), vec2(kBelowOne));
}
/// The same of a square of count x count.
inline vec2 into_cell(const uvec2& cell, uint32_t count, const vec2& u) { return into_cell(cell, uvec2(count), u); }

/// The bins of one light: a square of directions after the other, for one place after the other.
struct EmissionGrid {
    uint32_t light;
    uint32_t first_bin;
    EmissionResolution resolution;

    struct Bin {
        uvec2 place;
        uvec2 direction;
    };
    /// `index` counts from 0 for each light.
    Bin bin(uint32_t index) const {
        const uint32_t d = resolution.directions, p = resolution.places;
        return {uvec2(index / (d * d) % p, index / (d * d * p)), uvec2(index % d, index / d % d)};
    }
    uint32_t index(const Bin& bin) const {
        const uint32_t d = resolution.directions, p = resolution.places;
        return ((bin.place.y * p + bin.place.x) * d + bin.direction.y) * d + bin.direction.x;
    }
};

}  // namespace photond
