#pragma once
// A triangle that emits, as samplers of lights want it.

#include "renderer/core/geometry.h"

namespace photond {

struct Scene;
struct TriangleLight;

struct LightTriangle {
    vec3 corner;        // world space [m]: points are corner + s edge1 + t edge2, s + t <= 1
    vec3 edge1, edge2;  // s and t are the barycentrics u and v of hits
    vec3 normal;        // unit, the front side
    bool varies;        // radiance or coverage, by texture or alpha: to be asked for at each point (emission.h)
};

LightTriangle make_light_triangle(const Scene& scene, const TriangleLight& light);

}  // namespace photond
