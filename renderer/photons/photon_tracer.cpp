#include "renderer/photons/photon_tracer.h"

#include "renderer/core/parallel.h"
#include "renderer/core/thread_local.h"
#include "renderer/photons/photon_wavefront.h"

namespace photond {

struct PhotonTracer::Shared : PhotonTracingScene {
    using PhotonTracingScene::PhotonTracingScene;
    ThreadLocal<PhotonWavefront> wavefronts;
};

PhotonTracer::PhotonTracer(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
                           const PhotonTracing& tracing)
    : shared_(std::make_unique<Shared>(scene, intersector, emission, tracing)) {}
PhotonTracer::~PhotonTracer() = default;

uint64_t PhotonTracer::scratch_bytes(size_t threads) { return threads * PhotonWavefront::bytes_per_thread(); }

TracedPhotons PhotonTracer::trace(uint64_t seed, uint32_t pass, const CancelToken& cancel) const {
    const PhotonTracing& tracing = shared_->tracing;
    TracedPhotons traced;
    if (!(shared_->emission.total_power_w() > 0)) {  // paths without light
        traced.paths = traced.counts.photons_emitted = tracing.photons;
        return traced;
    }
    // Batches are cut where the runs of numbers are.
    const SequenceSampler sampler(tracing.sampler, seed, RandomDomain::Photons, static_cast<uint32_t>(tracing.kind));
    constexpr uint64_t kRun = SequenceSampler::kRun;
    const uint64_t first = uint64_t{pass} * tracing.photons, last = first + tracing.photons;
    const uint64_t first_run = first / kRun;
    const auto runs = static_cast<size_t>((last + kRun - 1) / kRun - first_run);

    struct Done {
        std::vector<Photon> photons;
        PhotonCounts counts;
    };
    std::vector<Done> batches(runs);
    parallel_for(runs, 1, [&](size_t i) {
        if (cancel.cancelled()) return;
        const uint64_t run = first_run + i, start = run * kRun;
        const PhotonBatch batch{run, static_cast<uint32_t>(std::max(first, start) - start),
                                static_cast<uint32_t>(std::min(last - start, kRun))};
        const std::span<const Photon> found =
            shared_->wavefronts.local().trace(*shared_, sampler, batch, batches[i].counts);
        batches[i].photons.assign(found.begin(), found.end());
    });

    std::vector<size_t> offsets(runs);
    size_t total = 0;
    for (size_t i = 0; i < runs; ++i) {
        offsets[i] = total;
        total += batches[i].photons.size();
        traced.counts += batches[i].counts.counts;
        traced.first_hits_specular += batches[i].counts.first_hits_specular;
    }
    traced.paths = traced.counts.photons_emitted;
    traced.photons.resize(total);
    parallel_for(runs, 8, [&](size_t i) {
        std::copy(batches[i].photons.begin(), batches[i].photons.end(),
                  traced.photons.begin() + static_cast<std::ptrdiff_t>(offsets[i]));
    });
    return traced;
}

}  // namespace photond
