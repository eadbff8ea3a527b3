#pragma once
// Scattering at a vertex between a path from the eye and one from a light: what is scattered, and with which density
// either of the two would have gone on to the other's last vertex. Methods that join such paths weigh by these; they
// are the same numbers at whichever path's end they are asked.
//
// All directions are world space, unit, and leave the surface. Delta lobes are in none of it: an ideal mirror or
// interface is chosen with the same probability from either side (nearly so where refraction shares the choice with
// other lobes), and is left out of weights on both.

#include "renderer/transport/bsdf.h"
#include "renderer/transport/photon_scattering.h"

namespace photond {

/// A surface and its lobes as a path met them.
struct SurfaceVertex {
    ShadingPoint point;
    Bsdf bsdf;
    vec3 from{0};  // back to where the path came from
};

/// The same place as met from `from`, on whichever side of the surface that is.
SurfaceVertex seen_from(const SurfaceVertex& vertex, const vec3& from);

/// At the end of a path from the eye, from where it goes on, or is joined, towards the light.
struct EyeScattering {
    Rgb f_cos{0};         // f |cos| [1/sr], the cosine against the shading normal
    float eye_pdf = 0;    // [1/sr] of `to`, for the eye's path
    float light_pdf = 0;  // [1/sr] of the way back, for a light path that comes from `to`
};
EyeScattering scatter_to_light(const SurfaceVertex& eye_vertex, const vec3& to);

/// At the end of a light path, from where it goes on, or is joined, towards the eye.
struct LightScattering {
    Rgb density{0};       // share of the power sent to each solid angle [1/sr], as scatter_density()
    float light_pdf = 0;  // [1/sr] of `to`, for the light path
    float eye_pdf = 0;    // [1/sr] of the way back, for an eye path that comes from `to`
};
LightScattering scatter_to_eye(const SurfaceVertex& light_vertex, const vec3& to);

// The densities alone, where something else has drawn the direction.
float eye_pdf_back(const SurfaceVertex& light_vertex, const vec3& to);
float light_pdf_back(const SurfaceVertex& eye_vertex, const vec3& to);

/// The normal that points on lights are drawn by at such a vertex: 0 where light from both sides counts. The same from
/// wherever the side is looked at, unlike the normal of the shading frame.
inline vec3 lit_normal(const SurfaceVertex& vertex) {
    return vertex.bsdf.has_non_delta_transmission() ? vec3(0) : vertex.point.smooth_normal;
}

}  // namespace photond
