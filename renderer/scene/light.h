#pragma once
// Lights as a scene holds them. Emissive triangles are found from the materials when the scene is finished.

#include <cstdint>
#include <string>

#include "renderer/core/rgb.h"

namespace photond {

/// KHR_lights_punctual, in world space. The numbers are radiometric as they stand.
struct PunctualLight {
    enum class Kind : uint8_t { Point, Spot, Directional };
    std::string name;
    Kind kind = Kind::Point;
    Rgb intensity{1};  // point, spot: radiant intensity [W sr^-1]; directional: perpendicular irradiance [W m^-2]
    vec3 position{0};
    vec3 direction{0, 0, -1};  // the light travels along it; unit
    float cos_inner = 1;       // spot: cosines of the cone's half-angles
    float cos_outer = 0;
    float range_m = kInfinity;  // nothing is lit beyond it
};

/// One emissive triangle of one instance.
struct TriangleLight {
    uint32_t instance;
    uint32_t triangle;
    float area_m2;  // world space
    Rgb radiance;   // mean over the triangle [W m^-2 sr^-1], texture included
    bool two_sided;
};

}  // namespace photond
