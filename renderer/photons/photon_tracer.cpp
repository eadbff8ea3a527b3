#include "renderer/photons/photon_tracer.h"

#include <atomic>
#include <mutex>
#include <optional>

#include "renderer/core/parallel.h"
#include "renderer/core/thread_local.h"
#include "renderer/photons/photon_arrivals.h"
#include "renderer/photons/photon_reflections.h"

namespace photond {

namespace {

/// Puts the batches' photons one behind the other as they come in, in the order of the batches: what is written once
/// need not be copied together at the end, and its pages are touched once. Of photons that arrive `surfaces` stay
/// empty.
template <class Kept>
class PhotonsInOrder {
public:
    explicit PhotonsInOrder(size_t batches) : waiting_(batches) {}

    void keep(size_t batch, std::span<const Kept> photons, std::span<const ReflectingSurface> surfaces,
              const PhotonCounts& counts) {
        const std::lock_guard lock(mutex_);
        counts_.counts += counts.counts;
        counts_.first_hits_specular += counts.first_hits_specular;
        if (batch != kept_) {
            waiting_[batch] = {.photons = {photons.begin(), photons.end()},
                               .surfaces = {surfaces.begin(), surfaces.end()},
                               .traced = true};
            return;
        }
        append(photons, surfaces);
        for (; kept_ < waiting_.size() && waiting_[kept_].traced;) {
            const Waiting mine = std::move(waiting_[kept_]);
            append(mine.photons, mine.surfaces);
        }
    }

    const PhotonCounts& counts() const { return counts_; }
    std::vector<Kept> take_photons() { return std::move(photons_); }
    std::vector<ReflectingSurface> take_surfaces() { return std::move(surfaces_); }

private:
    struct Waiting {
        std::vector<Kept> photons;
        std::vector<ReflectingSurface> surfaces;
        bool traced = false;
    };

    void append(std::span<const Kept> photons, std::span<const ReflectingSurface> surfaces) {
        ++kept_;
        const size_t first = photons_.size();
        append(photons_, photons);
        if constexpr (std::is_same_v<Kept, ReflectedPhoton>) {
            const auto before = static_cast<uint32_t>(surfaces_.size());
            if (before > 0)
                for (Kept& photon : std::span(photons_).subspan(first))
                    if (photon.surface != Kept::kNoSurface) photon.surface += before;
            append(surfaces_, surfaces);
        }
    }

    template <class T>
    void append(std::vector<T>& all, std::span<const T> mine) const {
        const size_t needed = all.size() + mine.size();
        if (needed > all.capacity()) {  // room for all, if the other batches are like those so far
            const double expected =
                1.1 * static_cast<double>(needed) * static_cast<double>(waiting_.size()) / static_cast<double>(kept_);
            all.reserve(std::max(static_cast<size_t>(expected), needed + needed / 4));
        }
        all.insert(all.end(), mine.begin(), mine.end());
    }

    std::mutex mutex_;
    std::vector<Waiting> waiting_;
    size_t kept_ = 0;  // batches
    std::vector<Kept> photons_;
    std::vector<ReflectingSurface> surfaces_;
    PhotonCounts counts_;
};

}  // namespace

struct PhotonTracer::Shared : PhotonTracingScene {
    /// Of one thread: a tracer's own, as much as it is used for.
    struct Scratch {
        PhotonWavefront wavefront;
        PhotonArrivals arrivals;
        PhotonReflections reflections;
    };

    Shared(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
           const PhotonTracing& tracing)
        : PhotonTracingScene(scene, intersector, emission, tracing) {
        if (tracing.injection == PhotonInjection::ReflectiveShadowMap && emission.total_power_w() > 0)
            maps.emplace(emission, tracing.photons);
    }

    SequenceSampler sampler(uint64_t seed) const {
        return {tracing.sampler, seed, RandomDomain::Photons, static_cast<uint32_t>(tracing.kind)};
    }
    SequenceRuns runs(uint32_t pass) const {
        const uint64_t first = uint64_t{pass} * tracing.photons;
        return {first, first + tracing.photons};
    }
    /// trace(scratch, place of the batch), in parallel. Threads take batches in their order, so that few wait for an
    /// earlier one to be kept.
    template <class Trace>
    void for_each_batch(const SequenceRuns& runs, const CancelToken& cancel, const Trace& trace) {
        const size_t count = runs.count();
        std::atomic<size_t> next{0};
        parallel_for(std::min(count, most_threads()), 1, [&](size_t) {
            Scratch& mine = threads.local();
            for (size_t i = next++; i < count && !cancel.cancelled(); i = next++) trace(mine, i);
        });
    }

    std::optional<ReflectiveShadowMaps> maps;
    ThreadLocal<Scratch> threads;
};

PhotonTracer::PhotonTracer(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
                           const PhotonTracing& tracing)
    : shared_(std::make_unique<Shared>(scene, intersector, emission, tracing)) {}
PhotonTracer::~PhotonTracer() = default;

uint64_t PhotonTracer::scratch_bytes(size_t threads) {
    return threads * (PhotonWavefront::bytes_per_thread() + PhotonArrivals::bytes_per_thread());
}

TracedPhotons PhotonTracer::trace(uint64_t seed, uint32_t pass, const CancelToken& cancel) const {
    const PhotonTracing& tracing = shared_->tracing;
    TracedPhotons traced;
    if (!(shared_->emission.total_power_w() > 0)) {  // paths without light
        traced.paths = traced.counts.photons_emitted = tracing.photons;
        return traced;
    }
    const SequenceSampler sampler = shared_->sampler(seed);
    const SequenceRuns runs = shared_->runs(pass);
    PhotonsInOrder<Photon> in_order(runs.count());
    shared_->for_each_batch(runs, cancel, [&](Shared::Scratch& mine, size_t i) {
        PhotonCounts counts;
        const std::span<const Photon> photons =
            mine.arrivals.trace(mine.wavefront, *shared_, sampler, {runs[i]}, counts);
        in_order.keep(i, photons, {}, counts);
    });
    traced.photons = in_order.take_photons();
    traced.counts = in_order.counts().counts;
    traced.paths = traced.counts.photons_emitted;
    traced.first_hits_specular = in_order.counts().first_hits_specular;
    return traced;
}

TracedReflections PhotonTracer::trace_reflected(uint64_t seed, uint32_t pass, const CancelToken& cancel) const {
    const PhotonTracing& tracing = shared_->tracing;
    TracedReflections traced;
    if (!(shared_->emission.total_power_w() > 0)) {
        traced.paths = traced.counts.photons_emitted = tracing.photons;
        return traced;
    }
    std::optional<ReflectiveShadowMapPass> texels;
    if (shared_->maps) texels.emplace(*shared_->maps, seed, pass);
    const SequenceSampler sampler = shared_->sampler(texels ? texels->seed() : seed);
    const SequenceRuns runs = texels ? SequenceRuns{0, texels->texels()} : shared_->runs(pass);
    const ReflectiveShadowMapPass* grid = texels ? &*texels : nullptr;
    PhotonsInOrder<ReflectedPhoton> in_order(runs.count());
    shared_->for_each_batch(runs, cancel, [&](Shared::Scratch& mine, size_t i) {
        PhotonCounts counts;
        const ReflectedBatch reflected =
            mine.reflections.trace(mine.wavefront, *shared_, sampler, {runs[i], grid}, counts.counts);
        in_order.keep(i, reflected.photons, reflected.surfaces, counts);
    });
    traced.photons = in_order.take_photons();
    traced.surfaces = in_order.take_surfaces();
    traced.counts = in_order.counts().counts;
    traced.paths = traced.counts.photons_emitted;
    return traced;
}

}  // namespace photond
