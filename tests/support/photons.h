#pragma once
// Photons from within a test.

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/scene/scene.h"

namespace photond::test {

/// A scene with what photon tracing needs of it.
class PhotonScene {
public:
    explicit PhotonScene(Scene made) : scene(std::move(made)), emission(scene) {
        MemoryBudget budget;
        Stats stats;
        intersector = make_embree_intersector(scene, budget, stats);
    }
    TracedPhotons trace(const PhotonTracing& tracing, uint64_t seed = 1, uint32_t pass = 0) const {
        return PhotonTracer(scene, *intersector, emission, tracing).trace(seed, pass, CancelToken{});
    }
    TracedReflections trace_reflected(const PhotonTracing& tracing, uint64_t seed = 1, uint32_t pass = 0) const {
        return PhotonTracer(scene, *intersector, emission, tracing).trace_reflected(seed, pass, CancelToken{});
    }

    const Scene scene;
    const EmissionSampler emission;
    std::unique_ptr<Intersector> intersector;
};

inline PhotonTracing photon_tracing(PhotonMapKind kind, uint32_t photons) {
    PhotonTracing tracing;
    tracing.kind = kind;
    tracing.photons = photons;
    return tracing;
}

/// Power [W] of the photons that `takes` accepts.
template <class Takes>
dvec3 power_of(const TracedPhotons& traced, const Takes& takes) {
    dvec3 sum(0);
    for (const Photon& photon : traced.photons)
        if (takes(photon)) sum += dvec3(photon.payload.power_w);
    return sum;
}
inline dvec3 power_after(const TracedPhotons& traced, uint32_t scatterings) {
    return power_of(traced, [=](const Photon& p) { return p.payload.scatterings() == scatterings; });
}

}  // namespace photond::test
