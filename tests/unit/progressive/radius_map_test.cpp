// Radii by place: means of what is known about a place, without steps in the mean.

#include "renderer/progressive/radius_map.h"

#include <gtest/gtest.h>

#include "renderer/core/rng.h"

namespace photond::radius_map_test {
namespace {

std::vector<PlacedRadius> places(size_t count, const auto& radius_at) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<PlacedRadius> known;
    for (size_t i = 0; i < count; ++i) {
        const vec3 p(random.next(), random.next(), 0);
        known.push_back({p, radius_at(p)});
    }
    return known;
}

TEST(RadiusMap, WithoutPlacesItIsTheOtherRadius) {
    const RadiusMap map({}, 0.25f);
    EXPECT_EQ(map.radius_m({1, 2, 3}, 7), 0.25f);
    EXPECT_EQ(map.most_m(), 0.25f);
}

TEST(RadiusMap, OneRadiusIsThatEverywhere) {
    const RadiusMap map(places(1000, [](const vec3&) { return 0.125f; }), 1);
    for (uint32_t turn = 0; turn < 100; ++turn)
        EXPECT_FLOAT_EQ(map.radius_m({0.01f * float(turn), 5, -3}, turn), 0.125f);
    EXPECT_FLOAT_EQ(map.most_m(), 0.125f);
}

TEST(RadiusMap, PlacesAtOnePointMakeOneLeaf) {
    std::vector<PlacedRadius> known(100, {vec3(1), 0.5f});
    for (size_t i = 0; i < 50; ++i) known[i].radius_m = 2;
    EXPECT_FLOAT_EQ(RadiusMap(known, 9).radius_m(vec3(1), 3), 1) << "the geometric mean";
}

TEST(RadiusMap, FollowsWhatIsKnown) {
    const auto radius_at = [](const vec3& p) { return std::exp(p.x - 2 * p.y); };
    const RadiusMap map(places(20'000, radius_at), 1);
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 1000; ++i) {
        const vec3 p(random.next(), random.next(), 0);
        // A leaf of 7 to 12 of 20,000 places is about 0.022 wide, and p moves half of that.
        EXPECT_NEAR(std::log(map.radius_m(p, random.next_bits())), std::log(radius_at(p)), 0.12f);
    }
}

TEST(RadiusMap, TheMeanHasNoStepsWhereLeavesMeet) {
    const auto radius_at = [](const vec3& p) { return p.x < 0.5f ? 1.0f : 2.0f; };
    const RadiusMap map(places(400, radius_at), 1);
    const auto mean_at = [&](float x) {
        double sum = 0;
        for (uint32_t turn = 0; turn < 4000; ++turn) sum += double{map.radius_m({x, 0.37f, 0}, hash32(turn))};
        return sum / 4000;
    };
    double steepest = 0;
    for (float x = 0.3f; x < 0.7f; x += 0.005f)
        steepest = std::max(steepest, std::abs(mean_at(x + 0.005f) - mean_at(x)));
    // Leaves are about 0.15 wide: a step of 1 is spread over as much, where without the turn it would be one.
    EXPECT_LT(steepest, 0.35);
    EXPECT_NEAR(mean_at(0.1f), 1, 1e-6);
    EXPECT_NEAR(mean_at(0.9f), 2, 1e-6);
}

}  // namespace
}  // namespace photond::radius_map_test
