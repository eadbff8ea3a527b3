#include "server/worker/photon_yield.h"

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/photons/photon_guides.h"
#include "renderer/photons/photon_tracer.h"
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
    PhotonGuides guides;
    const auto measure = [&](PhotonMapKind kind) {
        tracing.kind = kind;
        tracing.guide = nullptr;
        PhotonYield::OfMap yield;
        yield.unguided = yield.guided = share_stored();
        guides.add(kind, scene, *intersector, emission, tracing.glossy_threshold, kSeed, unlimited, uncounted);
        tracing.guide = guides.of(kind);
        if (tracing.guide) yield.guided = share_stored();
        return yield;
    };
    PhotonYield yield;
    yield.global = measure(PhotonMapKind::Global);
    if (scene.needs.delta || scene.needs.glossy) yield.caustic = measure(PhotonMapKind::Caustic);
    return yield;
}

}  // namespace photond
