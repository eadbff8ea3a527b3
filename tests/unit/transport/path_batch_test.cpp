// Batches of paths and of shadow rays: what goes on, what is asked, and in which order it is answered.

#include "renderer/transport/path_batch.h"

#include <gtest/gtest.h>

namespace photond::path_batch_test {
namespace {

/// Rays that start left of 0 meet instance 7; those that start right of it are occluded.
class HalfSpace final : public Intersector {
public:
    Hit closest_hit(const Ray& ray) const override { return ray.origin.x < 0 ? Hit{.t = 1, .instance = 7} : Hit{}; }
    bool occluded(const Ray& ray) const override { return ray.origin.x > 0; }
    void closest_hits(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const override {
        asked = rays.size();
        for (size_t i = 0; i < rays.size(); ++i) hits[i] = closest_hit(rays[i]);
    }
    void occluded(std::span<const Ray> rays, std::span<uint8_t> answers, Coherence) const override {
        asked = rays.size();
        for (size_t i = 0; i < rays.size(); ++i) answers[i] = occluded(rays[i]);
    }
    uint64_t bytes() const override { return 0; }

    mutable size_t asked = 0;
};

Ray ray_from(float x) { return {vec3(x, 0, 0), vec3(0, 0, 1), kInfinity}; }

TEST(PathBatch, OnlyPathsUnderWayAreTracedAndThoseKeptGoOn) {
    const HalfSpace intersector;
    PathBatch<int> batch(8);
    for (const int state : {10, 11, 12}) {
        batch.paths[batch.count] = state;
        batch.keys[batch.count] = static_cast<uint32_t>(state + 100);
        batch.rays[batch.count++] = ray_from(state == 11 ? 1.0f : -1.0f);
    }
    batch.find_hits(intersector, Coherence::Incoherent);
    EXPECT_EQ(intersector.asked, 3u);
    EXPECT_TRUE(batch.hits[0].valid() && !batch.hits[1].valid() && batch.hits[2].valid());

    batch.next_path() = 20;  // written and given up: the next one takes its place
    batch.next_path() = 22;
    batch.next_ray() = ray_from(5);
    batch.keep_next(batch.keys[2]);
    batch.advance();
    EXPECT_EQ(batch.count, 1u);
    EXPECT_EQ(batch.paths[0], 22);
    EXPECT_EQ(batch.keys[0], 112u);
    EXPECT_EQ(batch.rays[0].origin.x, 5);
    EXPECT_EQ(batch.former_path(1), 11);
    EXPECT_EQ(batch.former_key(1), 111u);
    batch.advance();
    EXPECT_EQ(batch.count, 0u);
}

TEST(PathBatch, RoomGrowsAndWhatIsThereStays) {
    PathBatch<int> batch;
    EXPECT_EQ(batch.room(), 0u);
    batch.make_room(2);
    batch.paths[1] = 5;
    batch.make_room(1);
    EXPECT_EQ(batch.room(), 2u);
    batch.make_room(9);
    EXPECT_EQ(batch.room(), 9u);
    EXPECT_EQ(batch.paths[1], 5);
}

TEST(ShadowBatch, VisitsWhatIsFreeInTheOrderItWasAdded) {
    const HalfSpace intersector;
    ShadowBatch<int> shadows(4);
    EXPECT_TRUE(shadows.has_room_for(4));
    for (const int sample : {1, 2, 3}) shadows.add(ray_from(sample == 2 ? 1.0f : -1.0f), sample);
    EXPECT_FALSE(shadows.has_room_for(2));
    std::vector<int> seen;
    EXPECT_EQ(shadows.trace(intersector, Coherence::Coherent, [&](int sample) { seen.push_back(sample); }), 3u);
    EXPECT_EQ(seen, (std::vector<int>{1, 3}));
    EXPECT_EQ(shadows.trace(intersector, Coherence::Coherent, [&](int sample) { seen.push_back(sample); }), 0u);
    EXPECT_EQ(seen.size(), 2u);
}

}  // namespace
}  // namespace photond::path_batch_test
