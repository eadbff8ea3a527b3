#pragma once
// Visible points: where paths from the eye wait for indirect light.

#include "renderer/eye/eye_path.h"
#include "renderer/transport/bsdf.h"

namespace photond {

/// A plain Lambert reflector that the eye sees, alone or in mirrors.
struct LambertVisiblePoint {
    vec3 position;          // world [m]
    vec3 geometric_normal;  // unit, on the eye's side
    vec3 normal;            // unit: the one that shades; the light sampler was given it too
    Rgb weight;             // throughput of the path up to here times reflectance: radiance is weight / pi * irradiance
    uint32_t pixel;
    uint32_t scatterings;  // of the path before this point
    Rgb reflectance;
    uint32_t path;  // SpecularWalk::path() and path_key() tell more while the point is handed over
};

/// Any other: the rough part f_d of its BSDF waits.
struct VisiblePoint {
    ShadingPoint surface;
    Bsdf rough;       // f_d
    vec3 wo;          // local
    Rgb throughput;   // of the path up to here
    float eta_scale;  // as in EyePath
    uint32_t pixel;
    uint32_t scatterings;  // of the path before this point
    MediumStack media;
    uint32_t path_key;  // of the sampler; vertex: number of the point's vertex on the path
    uint32_t vertex;
    vec3 lit_normal;  // as given to the light sampler
};

}  // namespace photond
