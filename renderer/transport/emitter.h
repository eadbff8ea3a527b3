#pragma once
// The lights of finite position that the light tree is built over, as the sampler of lights holds them.

#include <cstdint>

#include "renderer/core/rgb.h"

namespace photond {

inline constexpr uint32_t kNoEmitter = ~0u;

/// A light of finite position: a triangle, two triangles that make a parallelogram, a point or a spot.
struct Emitter {
    enum class Shape : uint8_t { Triangle, Parallelogram, Point, Spot };

    vec3 corner;        // points, spots: the position
    vec3 edge1, edge2;  // triangle: corner + s edge1 + t edge2, s + t <= 1; parallelogram: s, t <= 1
    vec3 normal;        // unit, the front side
    float area_m2;
    Rgb radiance;       // of constant emitters [W m^-2 sr^-1]
    uint32_t instance;  // triangles: where it is in the scene; points, spots: index of the punctual light
    uint32_t triangle;
    Shape shape;
    bool two_sided;
    bool varies;  // by texture or coverage: asked for at the point drawn
};

}  // namespace photond
