// Which index lies outside of a surface, in solids that are nested, that overlap and that are met from within.

#include "renderer/transport/medium_stack.h"

#include <gtest/gtest.h>

namespace photond::medium_stack_test {
namespace {

constexpr uint32_t kGlass = 0, kWater = 1, kDiamond = 2;

Scene three_solids() {
    Scene scene;
    scene.materials.resize(3);
    scene.materials[kGlass].ior = 1.5f;
    scene.materials[kWater].ior = 1.33f;
    scene.materials[kDiamond].ior = 2.4f;
    return scene;
}

/// A walk's surfaces, in through a front or out through a back, and the index outside of each.
struct Walk {
    const Scene scene = three_solids();
    MediumStack media = {};

    float enter(uint32_t material) { return pass(material, true); }
    float leave(uint32_t material) { return pass(material, false); }
    float pass(uint32_t material, bool from_front) {
        const float outside = media.outside_ior(scene, material, !from_front);
        media.cross(material, from_front);
        return outside;
    }
};

TEST(MediumStack, NestedSolidsHaveTheNextOneOutside) {
    Walk walk;
    EXPECT_EQ(walk.enter(kGlass), 1.0f);
    EXPECT_EQ(walk.enter(kWater), 1.5f);
    EXPECT_EQ(walk.enter(kDiamond), 1.33f);
    EXPECT_EQ(walk.leave(kDiamond), 1.33f);
    EXPECT_EQ(walk.leave(kWater), 1.5f);
    EXPECT_EQ(walk.leave(kGlass), 1.0f);
}

TEST(MediumStack, WhereSolidsOverlapTheFrontBendsAndTheBackDoesNot) {
    // From the glass into the water, whose face lies a hair within the glass.
    Walk in;
    in.enter(kGlass);
    EXPECT_EQ(in.enter(kWater), 1.5f);
    EXPECT_EQ(in.leave(kGlass), 1.5f) << "its own index: nothing bends";
    EXPECT_EQ(in.media.top(), kWater);
    EXPECT_EQ(in.leave(kWater), 1.0f);
    EXPECT_EQ(in.media.top(), MediumStack::kVacuum);

    // And back: one face bends, by the same two indices, on this way too.
    Walk out;
    out.enter(kWater);
    EXPECT_EQ(out.enter(kGlass), 1.33f);
    EXPECT_EQ(out.leave(kWater), 1.33f);
    EXPECT_EQ(out.leave(kGlass), 1.0f);
}

TEST(MediumStack, OneMaterialTwiceIsOneBody) {
    Walk walk;
    walk.enter(kGlass);
    EXPECT_EQ(walk.enter(kGlass), 1.5f);
    EXPECT_EQ(walk.leave(kGlass), 1.5f);
    EXPECT_EQ(walk.leave(kGlass), 1.0f);
}

TEST(MediumStack, ASolidThatTheRayBeganInHasAirOutside) {
    Walk walk;
    EXPECT_EQ(walk.leave(kGlass), 1.0f);
    walk.enter(kWater);
    EXPECT_EQ(walk.leave(kGlass), 1.33f) << "never entered: the water lies around it";
}

}  // namespace
}  // namespace photond::medium_stack_test
