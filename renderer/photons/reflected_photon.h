#pragma once
// Light that leaves a surface: a light path at one of its scatterings, ready to light something else from there. Splats
// start here (methods/photon_splatting).

#include "renderer/photons/photon.h"
#include "renderer/scene/intersector.h"

namespace photond {

struct ReflectedPhoton {
    static constexpr uint32_t kNoSurface = ~0u;
    static constexpr uint32_t kMostCaster = (1u << 22) - 1;

    /// How the light is spread over the directions it may leave to.
    enum class Spread : uint8_t {
        /// A plain Lambert reflector: intensity power_w / pi * cos [W/sr] about `normal`, times `correction` in
        /// directions on the smooth normal's side (photon_scattering.h). `direction` was drawn with density cos / pi
        /// about `normal`.
        Lambert,
        /// By the rough part of a BSDF: intensity arriving_power_w * f(w) |cos_g(w)| with what `surface` refers to.
        /// `direction` was drawn with density cos / pi about `normal`; power_w is arriving_power_w times the rough
        /// part's albedo, about the flux that leaves.
        Rough,
        /// All along `direction`: what a delta lobe, a narrow one, or one that transmits has scattered there.
        Beam,
    };

    vec3 position{0};               // world [m], on the surface
    Rgb power_w{0};                 // flux that leaves [W], over the number of light paths EMITTED
    vec3 normal{0};                 // geometric, unit, on the side the light arrived at
    vec3 direction{0};              // world, unit
    uint32_t smooth_normal = 0;     // Octahedral<16>, on `normal`'s side
    float correction = 1;           // of Lambert: |cos_s| / |cos_g| of the arriving direction
    uint32_t surface = kNoSurface;  // of Rough: index into TracedReflections::surfaces
    uint32_t scatterings_and_spread = 0;

    /// `caster`: of Beam, the instance that scattered it.
    static uint32_t pack(uint32_t scatterings, Spread spread, uint32_t caster = 0) {
        return std::min(scatterings, 255u) | static_cast<uint32_t>(spread) << 8 | std::min(caster, kMostCaster) << 10;
    }
    /// Scatterings since the light, the one here included: at least 1.
    uint32_t scatterings() const { return scatterings_and_spread & 0xffu; }
    Spread spread() const { return static_cast<Spread>(scatterings_and_spread >> 8 & 0x3u); }
    /// Of Beam: the instance that scattered it; kMostCaster stands for all from there.
    uint32_t caster() const { return scatterings_and_spread >> 10; }
    /// Flux along `w` (unit, world) over that of a Lambert reflector without shading normals.
    float correction_towards(const vec3& w) const {
        if (correction == 1) return 1;
        return glm::dot(Octahedral<16>::decode(smooth_normal), w) > 0 ? correction : 1;
    }
};
static_assert(sizeof(ReflectedPhoton) == 64);

/// What is needed to evaluate the BSDF at a photon's place again: make_shading_point(scene, hit, -wi_world), and
/// make_bsdf() with `outside_ior`, of which rough_part(PhotonTracing::glossy_threshold) is meant.
struct ReflectingSurface {
    Hit hit;
    vec3 wi_world{0};         // unit, from the surface towards where the light came from
    Rgb arriving_power_w{0};  // flux [W], over the number of paths and the probability that this photon was kept
    float outside_ior = 1;
};

}  // namespace photond
