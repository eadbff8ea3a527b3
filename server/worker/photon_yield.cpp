#include "server/worker/photon_yield.h"

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/photons/projection_map.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr uint64_t kMostTriangles = 400'000;
constexpr uint32_t kPaths = 16'384;  // a share to some 1 %
constexpr uint64_t kSeed = 1;

}  // namespace

std::optional<PhotonYield> measure_photon_yield(const Scene& scene) {
    if (scene.triangle_count > kMostTriangles || scene.triangle_count == 0) return std::nullopt;
    const EmissionSampler emission(scene);
    if (!(emission.total_power_w() > 0)) return std::nullopt;
    MemoryBudget unlimited;
    Stats uncounted;
    const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, unlimited, uncounted);
    PhotonTracing tracing;
    tracing.photons = kPaths;
    const auto share_stored = [&] {
        const TracedPhotons traced =
            PhotonTracer(scene, *intersector, emission, tracing).trace(kSeed, 0, CancelToken{});
        return static_cast<double>(traced.photons.size()) / kPaths;
    };
    PhotonYield yield;
    tracing.kind = PhotonMapKind::Global;
    yield.global = share_stored();
    if (!scene.needs.delta && !scene.needs.glossy) return yield;
    const ProjectionMap guide(scene, *intersector, emission, tracing.glossy_threshold, kSeed);
    tracing.kind = PhotonMapKind::Caustic;
    yield.caustic_unguided = share_stored();
    tracing.guide = guide.helps() ? &guide : nullptr;
    yield.caustic = tracing.guide ? share_stored() : yield.caustic_unguided;
    return yield;
}

}  // namespace photond
