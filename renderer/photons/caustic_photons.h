#pragma once
// Caustics for methods that connect: the light that reached a surface by specular scatterings alone, as photons.
//
// No connection finds such light, and a path from the eye meets a small light through glass by rare chance. So it comes
// from a photon map of its own: light paths led to what is specular (projection_map.h), which end at the first surface
// with another lobe; there, and at every vertex of a path from the eye with such a lobe, the map is looked up. The
// light of lights that a path from the eye meets behind a specular scattering is then the map's, and must not be added.
//
// The estimate blurs within its radius, which shrinks from pass to pass (radius_schedule.h): the mean of the passes
// converges. The first radius is a pilot's: so wide that where caustics are bright some forty photons are within it.
// GPU twin: caustic_photons_gpu.h.

#include <memory>
#include <optional>

#include "renderer/core/cancel.h"
#include "renderer/core/stats.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/photons/radiance_estimate.h"

namespace photond {

/// Of scenes in which nobody has measured it: caustic photons a light path, led to specular surfaces where that pays
/// (0.63 in the built-in box with the glass sphere).
inline constexpr double kExpectedCausticYield = 0.3;

/// Whether any surface has a lobe that is specular at the threshold. Textures can only lower a roughness: where there
/// is one, any is taken for possible.
bool has_specular_surface(const Scene& scene, float glossy_threshold);

struct CausticSettings {
    uint32_t photons = 100'000;              // light paths a pass
    uint32_t most_scatterings = UINT32_MAX;  // of a photon, before it is looked up
    float glossy_threshold = 0.05f;          // GGX alpha: lobes below it are specular
    SamplerKind sampler = SamplerKind::Sobol;
    std::optional<float> radius_m;  // of the first pass; a pilot's where it is not given
};

/// A pass's photons, and how they are looked up.
struct CausticMap {
    PhotonMap map;
    EstimateSettings estimate;
    float glossy_threshold = 0;

    /// What `rough` (of lobes that are not specular) scatters of it towards `wo`, both local to the point's shading
    /// frame, by photons of at most so many scatterings.
    Rgb radiance(const ShadingPoint& point, const Bsdf& rough, const vec3& wo, uint32_t most_scatterings,
                 Neighbours& scratch) const;
    /// Irradiance [W m^-2] of a Lambert reflector: `normal` is the one that shades.
    Rgb irradiance(const vec3& position, const vec3& geometric_normal, const vec3& normal, uint32_t most_scatterings,
                   Neighbours& scratch) const;
};

/// Borrows scene, intersector and emission.
class CausticPhotons {
public:
    /// Traces the pilots: stage `photon_emission`. Where guiding does not pay, why stands among what was skipped.
    CausticPhotons(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
                   const CausticSettings& settings, uint64_t seed, Stats& stats);
    ~CausticPhotons();

    /// One pass's map: a pure function of (scene, settings, seed, pass). Stages `photon_tracing` and
    /// `photon_map_build`. Cancelled: what comes back is incomplete and must not be used.
    CausticMap trace(uint32_t pass, Stats& stats, const CancelToken& cancel) const;
    float radius_m(uint32_t pass) const;

    // For the twin in caustic_photons_gpu.h: the paths, whose guide stays this one's; how passes estimate; and how many
    // photons a path left in the pilot, or is taken to.
    PhotonTracing tracing() const;
    static EstimateSettings estimate();
    double photons_a_path() const;

    /// Of what passes share.
    uint64_t bytes() const;
    /// The same at most, what building it takes for a while included.
    static uint64_t estimate_bytes(uint64_t lights, size_t threads);
    /// Of a pass's map while it is built, where each light path leaves so many photons.
    static uint64_t map_bytes(const CausticSettings& settings, double yield);

private:
    struct Shared;
    std::unique_ptr<const Shared> shared_;
};

}  // namespace photond
