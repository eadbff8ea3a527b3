// Photon maps of both structures: what was put in is found where it lies, with its own payload.

#include "renderer/photons/photon_map.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/core/rng.h"
#include "tests/support/threads.h"

namespace photond::photon_map_test {
namespace {

constexpr PhotonSearch kNearest{.kind = PhotonSearch::Kind::Nearest, .nearest = 20, .radius_m = 0.2f};
constexpr PhotonSearch kRadius{.kind = PhotonSearch::Kind::Radius, .nearest = 20, .radius_m = 0.1f};

vec3 next_point(RandomStream& random) {
    const float x = random.next(), y = random.next();
    return {x, y, random.next() < 0.5f ? 0.0f : 0.3f * x};
}

/// Photons whose power says which they are.
std::vector<Photon> make_photons(size_t count) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<Photon> photons(count);
    for (size_t i = 0; i < count; ++i) {
        photons[i].position = next_point(random);
        photons[i].payload = PhotonPayload::make(Rgb(static_cast<float>(i)), vec3(0, 0, 1), vec3(0, 1, 0),
                                                 static_cast<uint32_t>(i % 7), i % 3 == 0);
    }
    return photons;
}

size_t identity(const PhotonMap& map, uint32_t index) { return static_cast<size_t>(map.payload(index).power_w.x); }

std::vector<size_t> find(const PhotonMap& map, const vec3& p, float& radius_m) {
    Neighbours out;
    map.find(p, out);
    radius_m = out.radius_m;
    std::vector<size_t> found;
    for (const Neighbours::Found& f : out.found) found.push_back(identity(map, f.index));
    std::sort(found.begin(), found.end());
    return found;
}

TEST(PhotonMap, PayloadsFollowTheirPositions) {
    const std::vector<Photon> photons = make_photons(5000);
    for (const PhotonSearch& search : {kNearest, kRadius}) {
        const PhotonMap map(photons, search);
        ASSERT_EQ(map.size(), photons.size());
        EXPECT_EQ(map.kd_tree() != nullptr, search.kind == PhotonSearch::Kind::Nearest);
        EXPECT_EQ(map.hash_grid() != nullptr, search.kind == PhotonSearch::Kind::Radius);
        std::vector<bool> seen(photons.size());
        for (uint32_t i = 0; i < map.size(); ++i) {
            const size_t id = identity(map, i);
            ASSERT_LT(id, photons.size());
            EXPECT_FALSE(seen[id]) << "twice";
            seen[id] = true;
            EXPECT_EQ(map.position(i), photons[id].position);
            EXPECT_EQ(map.payload(i).scatterings(), id % 7);
            EXPECT_EQ(map.payload(i).all_delta(), id % 3 == 0);
        }
    }
}

TEST(PhotonMap, FindsWhatALoopFinds) {
    const std::vector<Photon> photons = make_photons(4000);
    const PhotonMap nearest(photons, kNearest), radius(photons, kRadius);
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (int query = 0; query < 200; ++query) {
        const vec3 p = next_point(random);
        std::vector<std::pair<double, size_t>> by_distance;
        for (size_t i = 0; i < photons.size(); ++i)
            by_distance.emplace_back(glm::distance(dvec3(p), dvec3(photons[i].position)), i);
        std::sort(by_distance.begin(), by_distance.end());

        float radius_m;
        std::vector<size_t> expected;
        for (size_t i = 0; i + 1 < kNearest.nearest; ++i) expected.push_back(by_distance[i].second);
        std::sort(expected.begin(), expected.end());
        EXPECT_EQ(find(nearest, p, radius_m), expected) << "all but the k-th";
        EXPECT_NEAR(double{radius_m}, by_distance[kNearest.nearest - 1].first, 1e-6);

        expected.clear();
        for (const auto& [distance, i] : by_distance)
            if (distance < double{kRadius.radius_m}) expected.push_back(i);
        std::sort(expected.begin(), expected.end());
        EXPECT_EQ(find(radius, p, radius_m), expected);
        EXPECT_EQ(radius_m, kRadius.radius_m);
    }
}

TEST(PhotonMap, FewPhotonsOrNone) {
    float radius_m;
    EXPECT_TRUE(find(PhotonMap(), vec3(0), radius_m).empty());
    for (const PhotonSearch& search : {kNearest, kRadius}) {
        const PhotonMap none({}, search);
        EXPECT_TRUE(none.empty());
        EXPECT_EQ(none.kd_tree(), nullptr);
        EXPECT_EQ(none.hash_grid(), nullptr);
        EXPECT_TRUE(find(none, vec3(0), radius_m).empty());
        EXPECT_EQ(radius_m, search.radius_m);
        EXPECT_EQ(none.bytes(), 0u);

        const std::vector<Photon> photons = make_photons(1);
        const PhotonMap one(photons, search);
        EXPECT_EQ(find(one, photons[0].position, radius_m).size(), 1u);
        EXPECT_EQ(radius_m, search.radius_m) << "fewer than k: the search radius";
        EXPECT_TRUE(find(one, photons[0].position + vec3(1.01f * search.radius_m, 0, 0), radius_m).empty());
    }
}

TEST(PhotonMap, BytesAreWithinTheEstimate) {
    for (const size_t count : {size_t{1}, size_t{1000}, size_t{70'000}}) {
        for (const PhotonSearch& search : {kNearest, kRadius}) {
            const PhotonMap map(make_photons(count), search);
            EXPECT_GE(map.bytes(), count * (sizeof(PhotonPayload) + sizeof(vec3)));
            EXPECT_LE(map.bytes(), PhotonMap::bytes_for(count));
        }
    }
    EXPECT_LE(PhotonMap::bytes_for(1'000'000), 100'000'000u) << "under 100 bytes a photon, building included";
}

TEST(PhotonMap, TheSameForAnyNumberOfThreads) {
    const std::vector<Photon> photons = make_photons(100'000);
    for (const PhotonSearch& search : {kNearest, kRadius}) {
        const auto build = [&](int threads) {
            return test::on_threads(threads, [&] { return PhotonMap(photons, search); });
        };
        const PhotonMap one = build(1), four = build(4);
        for (uint32_t i = 0; i < one.size(); ++i) ASSERT_EQ(identity(one, i), identity(four, i));
    }
}

}  // namespace
}  // namespace photond::photon_map_test
