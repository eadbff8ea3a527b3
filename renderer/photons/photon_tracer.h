#pragma once
// Pass 1: light paths from the lights through the scene, and the photons they leave.
//
// Power is divided by the number of paths EMITTED and changes by f |cos_out| / (s p_out) at each scattering and by
// nothing at storage (methods.md, "Departures"). Shading normals: transport/photon_scattering.h.

#include <memory>
#include <vector>

#include "renderer/core/cancel.h"
#include "renderer/core/stats.h"
#include "renderer/photons/reflected_photon.h"
#include "renderer/scene/intersector.h"
#include "renderer/transport/emission_sampling.h"
#include "renderer/transport/sobol.h"

namespace photond {

class ProjectionMap;

/// Which photons are kept. A scattering is specular when its lobe is delta or glossy with alpha below the threshold.
enum class PhotonMapKind : uint8_t {
    Global,   // at least one scattering that was not specular
    Caustic,  // at least one scattering, all specular; paths end at the first that is not
};

/// How light paths start.
enum class PhotonInjection : uint8_t {
    Paths,  // along one long low-discrepancy sequence
    /// [Dachsbacher and Stamminger 2005]: each light renders a grid of texels, jittered anew each pass, of about as
    /// many in all as there are to be photons. Paths end at their first hit.
    ReflectiveShadowMap,
};

struct PhotonTracing {
    PhotonMapKind kind = PhotonMapKind::Global;
    uint32_t photons = 200'000;              // light paths a pass
    uint32_t most_scatterings = UINT32_MAX;  // photons with more are neither stored nor traced
    float glossy_threshold = 0.05f;          // alpha
    SamplerKind sampler = SamplerKind::Sobol;
    const ProjectionMap* guide = nullptr;                // of caustic photons; nullptr: by the lights' emission alone
    PhotonInjection injection = PhotonInjection::Paths;  // of trace_reflected()
    bool rough_apart = true;  // trace_reflected(): rough lobes as ReflectedPhoton::Spread::Rough, else as beams
    bool beams = true;        // trace_reflected(): false: those of Spread::Beam are not kept
};

/// What one call of trace() did.
struct TracedPhotons {
    /// Batches of paths one behind the other, whatever the number of threads; in a batch by scatterings, then by path
    /// (plain Lambert reflectors before others).
    std::vector<Photon> photons;
    uint64_t paths = 0;                // emitted
    uint64_t first_hits_specular = 0;  // paths whose first hit had a specular lobe
    Counts counts;                     // photon_rays, photons_emitted, photons_stored
};

/// What one call of trace_reflected() did.
struct TracedReflections {
    std::vector<ReflectedPhoton> photons;  // in an order that does not depend on the number of threads
    std::vector<ReflectingSurface> surfaces;
    std::vector<float> choices;  // the photons' (many_lights/vpl_shared.h); empty: none is said
    uint64_t paths = 0;          // emitted
    Counts counts;               // photon_rays, photons_emitted, photons_stored
};

/// Borrows scene, intersector, emission and guide.
class PhotonTracer {
public:
    PhotonTracer(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
                 const PhotonTracing& tracing);
    ~PhotonTracer();

    /// One pass's photons: a pure function of (scene, settings, seed, pass), traced in parallel in batches. Cancelled:
    /// what comes back is incomplete and must not be used.
    TracedPhotons trace(uint64_t seed, uint32_t pass, const CancelToken& cancel) const;

    /// The same paths, but what is kept is where they leave: one photon at each scattering up to `most_scatterings`,
    /// whatever the kind. Russian roulette keeps the photons' powers alike.
    TracedReflections trace_reflected(uint64_t seed, uint32_t pass, const CancelToken& cancel) const;

    /// Bytes of scratch all threads together take in trace().
    static uint64_t scratch_bytes(size_t threads);

private:
    struct Shared;
    std::unique_ptr<Shared> shared_;
};

}  // namespace photond
