#pragma once
// What rays a method asks for, kept so that the same rays can be traced again without it.

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <mutex>

#include "renderer/core/parallel.h"
#include "tests/benchmarks/bare_embree.h"

namespace photond {

/// Passes rays on and keeps a copy of every batch.
class RecordingIntersector final : public Intersector {
public:
    explicit RecordingIntersector(const Intersector& inner) : inner_(inner) {}
    Hit closest_hit(const Ray& ray) const override { return inner_.closest_hit(ray); }
    bool occluded(const Ray& ray) const override { return inner_.occluded(ray); }
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits, Coherence coherence) const override {
        inner_.closest_hits(rays, hits, coherence);
        record({{rays.begin(), rays.end()},
                coherence,
                false,
                size_t(std::count_if(hits.begin(), hits.end(), [](const Hit& hit) { return hit.valid(); }))});
    }
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded, Coherence coherence) const override {
        inner_.occluded(rays, occluded, coherence);
        record({{rays.begin(), rays.end()},
                coherence,
                true,
                size_t(std::count(occluded.begin(), occluded.end(), uint8_t{1}))});
    }
    uint64_t bytes() const override { return inner_.bytes(); }

    const std::vector<RecordedBatch>& batches() const { return batches_; }

    /// Traces everything that was recorded, as the renderer does.
    void replay() const {
        parallel_for(batches_.size(), 1, [&](size_t i) {
            const RecordedBatch& batch = batches_[i];
            Answers& answers = answers_.local();
            answers.occluded.resize(std::max(answers.occluded.size(), batch.rays.size()));
            answers.hits.resize(std::max(answers.hits.size(), batch.rays.size()));
            if (batch.shadow)
                inner_.occluded(batch.rays, {answers.occluded.data(), batch.rays.size()}, batch.coherence);
            else
                inner_.closest_hits(batch.rays, {answers.hits.data(), batch.rays.size()}, batch.coherence);
        });
    }

private:
    void record(RecordedBatch batch) const {
        const std::lock_guard lock(mutex_);
        batches_.push_back(std::move(batch));
    }

    struct Answers {
        std::vector<uint8_t> occluded;
        std::vector<Hit> hits;
    };

    const Intersector& inner_;
    mutable tbb::enumerable_thread_specific<Answers> answers_;
    mutable std::mutex mutex_;
    mutable std::vector<RecordedBatch> batches_;
};

}  // namespace photond
