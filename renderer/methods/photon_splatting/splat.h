#pragma once
// One splat: a photon's ray and what it brings to the points about it.

#include "renderer/core/rgb.h"
#include "renderer/photons/reflected_photon.h"

namespace photond {

struct Splat {
    enum class Kind : uint8_t {
        Connect,       // from a Lambert reflector: the same intensity in all directions
        ConnectRough,  // from the rough part of a BSDF, evaluated towards each point
        Beam,          // along its direction, spread across by the filter: the kernel estimator, and the thesis'
    };

    vec3 origin{0};  // world [m]: y, where the photon left
    /// Connections: over the radius that the receiver's place asks for (splat_sizes.h).
    float radius = 0;  // Beam: [m]
    vec3 axis{0};      // unit: w
    float disc = 1;    // Connect: of the disc that stands for the filter near y's horizon, over the radius
    /// Connections: power [W] (ConnectRough: the arriving power). Beam: over the squared radius [W m^-2].
    Rgb intensity{0};
    float near_m = 0;  // Beam: the part of the ray that it lights
    vec3 normal{0};    // Connect: geometric, at y
    float far_m = kInfinity;
    vec3 shadow_target{0};     // Connect: where shadow rays to y end, just off its surface
    float weight = 1;          // `normalised`: of its cell
    uint32_t photon = 0;       // index into TracedReflections::photons
    uint32_t caster = 0;       // Beam: ReflectedPhoton::caster()
    uint32_t slot = 0;         // Beam: in the depth maps of its chunk; ConnectRough: in its origins
    uint16_t scatterings = 1;  // of the photon
    Kind kind = Kind::Connect;
    bool corrected = false;  // Connect: by shading normals, ReflectedPhoton::correction_towards()
};

}  // namespace photond
