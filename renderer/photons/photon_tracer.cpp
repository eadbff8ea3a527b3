#include "renderer/photons/photon_tracer.h"

#include <atomic>
#include <mutex>

#include "renderer/core/parallel.h"
#include "renderer/core/thread_local.h"
#include "renderer/photons/photon_wavefront.h"

namespace photond {

namespace {

/// Puts the batches' photons one behind the other as they come in, in the order of the batches: what is written once
/// need not be copied together at the end, and its pages are touched once.
class PhotonsInOrder {
public:
    explicit PhotonsInOrder(size_t batches) : waiting_(batches) {}

    void keep(size_t batch, std::span<const Photon> photons, const PhotonCounts& counts) {
        const std::lock_guard lock(mutex_);
        counts_.counts += counts.counts;
        counts_.first_hits_specular += counts.first_hits_specular;
        if (batch != kept_) {
            waiting_[batch] = {.photons = {photons.begin(), photons.end()}, .traced = true};
            return;
        }
        append(photons);
        for (; kept_ < waiting_.size() && waiting_[kept_].traced;) {
            const std::vector<Photon> mine = std::move(waiting_[kept_].photons);
            append(mine);
        }
    }

    void finish(TracedPhotons& traced) {
        traced.photons = std::move(photons_);
        traced.counts = counts_.counts;
        traced.paths = counts_.counts.photons_emitted;
        traced.first_hits_specular = counts_.first_hits_specular;
    }

private:
    struct Waiting {
        std::vector<Photon> photons;
        bool traced = false;
    };

    void append(std::span<const Photon> photons) {
        ++kept_;
        const size_t needed = photons_.size() + photons.size();
        if (needed > photons_.capacity()) {  // room for all, if the other batches are like those so far
            const double expected =
                1.1 * static_cast<double>(needed) * static_cast<double>(waiting_.size()) / static_cast<double>(kept_);
            photons_.reserve(std::max(static_cast<size_t>(expected), needed + needed / 4));
        }
        photons_.insert(photons_.end(), photons.begin(), photons.end());
    }

    std::mutex mutex_;
    std::vector<Waiting> waiting_;
    size_t kept_ = 0;  // batches
    std::vector<Photon> photons_;
    PhotonCounts counts_;
};

}  // namespace

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

    // Threads take batches in their order, so that few wait for an earlier one to be kept.
    PhotonsInOrder in_order(runs);
    std::atomic<size_t> next{0};
    parallel_for(std::min(runs, most_threads()), 1, [&](size_t) {
        PhotonWavefront& wavefront = shared_->wavefronts.local();
        for (size_t i = next++; i < runs && !cancel.cancelled(); i = next++) {
            const uint64_t run = first_run + i, start = run * kRun;
            const PhotonBatch batch{run, static_cast<uint32_t>(std::max(first, start) - start),
                                    static_cast<uint32_t>(std::min(last - start, kRun))};
            PhotonCounts counts;
            const std::span<const Photon> photons = wavefront.trace(*shared_, sampler, batch, counts);
            in_order.keep(i, photons, counts);
        }
    });
    in_order.finish(traced);
    return traced;
}

}  // namespace photond
