#include "renderer/scene/intersector.h"

#include <algorithm>

#include "renderer/core/parallel.h"

namespace photond {

namespace {

class HitsThatCame final : public HitsToCome {
public:
    explicit HitsThatCame(std::vector<Hit> hits) : hits_(std::move(hits)) {}
    std::vector<Hit> take() override { return std::move(hits_); }

private:
    std::vector<Hit> hits_;
};

}  // namespace

std::unique_ptr<HitsToCome> Intersector::begin_closest_hits(std::vector<Ray> rays, Coherence coherence) const {
    constexpr size_t kBatch = 4096;
    std::vector<Hit> hits(rays.size());
    parallel_for((rays.size() + kBatch - 1) / kBatch, 1, [&](size_t batch) {
        const size_t first = batch * kBatch, count = std::min(kBatch, rays.size() - first);
        closest_hits(std::span(rays).subspan(first, count), std::span(hits).subspan(first, count), coherence);
    });
    return std::make_unique<HitsThatCame>(std::move(hits));
}

}  // namespace photond
