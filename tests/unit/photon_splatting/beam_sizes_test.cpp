// How wide beams are: few photons of a pass in a disc, none wider than its caster; and what is said where they are.

#include "renderer/methods/photon_splatting/beam_sizes.h"

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/render.h"
#include "tests/support/scene_parts.h"

namespace photond::beam_sizes_test {
namespace {

Material mirror(float roughness = 0) {
    Material material;
    material.roughness = roughness;
    return material;
}

TEST(BeamSizes, CastersAreAsWideAsTheirSecondSide) {
    Scene scene;
    test::add(scene, MeshBuilder().box({0, 0, 0}, {4, 1, 2}).build(0), mirror());
    test::add(scene, MeshBuilder().quad({0, 0, 0}, {3, 0, 0}, {3, 5, 0}, {0, 5, 0}).build(0), mirror());
    test::add(scene, MeshBuilder().box({0, 0, 0}, {4, 0.1f, 0.2f}).build(0), mirror(0.4f));
    test::add(scene, MeshBuilder().box({0, 0, 0}, {4, 1, 2}).build(0), mirror(0.6f));
    test::add(scene, MeshBuilder().box({0, 0, 0}, {4, 1, 2}).build(0), test::lambert(0.5f));
    const std::vector<float> radii_m = caster_radii_m(scene, 0.2f);
    ASSERT_EQ(radii_m.size(), 5u);
    EXPECT_FLOAT_EQ(radii_m[0], 1);
    EXPECT_FLOAT_EQ(radii_m[1], 1.5f);
    EXPECT_FLOAT_EQ(radii_m[2], 0.1f);
    EXPECT_EQ(radii_m[3], kInfinity);  // its lobes are too wide for beams
    EXPECT_EQ(radii_m[4], kInfinity);
}

/// A floor that beams fall on from one metre above, so many on each square metre of x in [0, 1] and of x in [1, 2].
struct Fall {
    Fall() {
        test::add(scene, MeshBuilder().quad({-9, 0, 9}, {9, 0, 9}, {9, 0, -9}, {-9, 0, -9}).build(0),
                  test::lambert(0.5f));
        test::add(scene, MeshBuilder().quad({0, 1, 1}, {1, 1, 1}, {1, 1, 0.99f}, {0, 1, 0.99f}).build(0), mirror());
        finish_scene(scene);
        intersector = make_embree_intersector(scene, budget, stats);
        RandomStream random(1, RandomDomain::Test, 0, 0);
        for (uint32_t i = 0; i < kDense + kSparse; ++i) {
            ReflectedPhoton photon;
            photon.position = vec3(random.next() + (i < kDense ? 0.0f : 1.0f), 1, random.next());
            photon.normal = photon.direction = vec3(0, -1, 0);
            photon.scatterings_and_spread = ReflectedPhoton::pack(1, ReflectedPhoton::Spread::Beam, 1);
            pilot.photons.push_back(photon);
        }
        pilot.paths = kPaths;
    }
    BeamSizes sizes(float most_m, uint32_t paths) const {
        Counts counts;
        return {most_m, paths, {kInfinity, 0.03f}, pilot, *intersector, counts};
    }

    static constexpr uint32_t kDense = 4000, kSparse = 250, kPaths = 8000;
    Scene scene;
    MemoryBudget budget;
    Stats stats;
    std::unique_ptr<Intersector> intersector;
    TracedReflections pilot;
};

TEST(BeamSizes, DiscsHoldFewPhotonsOfAPass) {
    const Fall fall;
    for (const uint32_t paths : {8000u, 32000u}) {
        const BeamSizes sizes = fall.sizes(0.4f, paths);
        for (const auto& [x, photons] : {std::pair{0.5f, Fall::kDense}, std::pair{1.5f, Fall::kSparse}}) {
            double mean = 0;
            constexpr int kPlaces = 64;
            for (int i = 0; i < kPlaces; ++i) {
                const vec3 at(x + 0.05f * float(i % 8 - 4), 0, 0.2f + 0.08f * float(i / 8));
                const float radius_m = sizes.radius_m({at, 1, 0}, 1);
                mean += double{kPi} * double{radius_m} * double{radius_m} * photons * paths / Fall::kPaths / kPlaces;
                // So many photons make a disc's width: that of nine of the same ones goes with the root.
                if (3 * radius_m < 0.4f) {
                    EXPECT_FLOAT_EQ(sizes.radius_m({at, 1, 0}, 9), 3 * radius_m);
                }
            }
            // Four are meant. The areas of discs of eight photons vary by a third; cells take the middle one of four.
            EXPECT_NEAR(mean, 4, 1) << x << ", " << paths << " paths";
        }
    }
}

TEST(BeamSizes, NoneIsWiderThanItsCasterNorThanItsWay) {
    const Fall fall;
    const BeamSizes sizes = fall.sizes(10, 1000);
    RandomStream random(2, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 1000; ++i) {
        const vec3 at(4 * random.next() - 1, 0, 2 * random.next() - 0.5f);
        EXPECT_LE(sizes.radius_m({at, 1, 1}, 1), 0.03f);
        EXPECT_LE(sizes.radius_m({at, 1, 1}, 100), 0.03f);
        EXPECT_LE(sizes.radius_m({at, 0.4f, 0}, 1), 0.2f);
        EXPECT_GT(sizes.radius_m({at, 0, 0}, 1), 0);
    }
    const BeamSizes narrow = fall.sizes(0.05f, 1000);
    EXPECT_LE(narrow.radius_m({vec3(1.5f, 0, 0.5f), 1, 0}, 1), 0.05f);
    // An instance that nobody knows has no width.
    EXPECT_EQ(narrow.radius_m({vec3(1.5f, 0, 0.5f), 1, ReflectedPhoton::kMostCaster}, 1), 0.05f);
    EXPECT_EQ(BeamSizes(0.5f).radius_m({vec3(0), 0, 1}, 4), 1);
}

std::string said_of_beams(const Scene& scene, const PhotonSplattingParams& params) {
    test::RenderSettingsOf<PhotonSplatting> settings;
    settings.size = {8, 8};
    settings.params = params;
    settings.params.photons = 50;
    Stats stats;
    test::render(scene, settings, &stats);
    std::string said;
    for (const Skipped& part : stats.skipped)
        if (part.what == "beams no wider than what casts them") said += part.why;
    return said;
}

TEST(BeamSizes, BeamsWiderThanTheirCasterAreSaid) {
    const Scene floor = make_builtin_scene("caustics/glass-on-floor"), box = make_builtin_scene("cornell-box-glass");
    PhotonSplattingParams params;
    EXPECT_EQ(said_of_beams(floor, params), "");
    params.adaptive_size = false;
    EXPECT_EQ(said_of_beams(floor, params),
              "warning: beams are 0.71 m wide, wider than 1 of the objects that cast them, of which the narrowest has "
              "0.1 m: they glow that far about themselves; take a smaller splat_size");
    EXPECT_EQ(said_of_beams(box, params), "");
    params.adaptive_size = true;
    params.estimator = SplatEstimator::Kernel;
    EXPECT_NE(said_of_beams(floor, params), "");
    params.splat_size_m = 0.09f;
    EXPECT_EQ(said_of_beams(floor, params), "");
    EXPECT_EQ(said_of_beams(make_builtin_scene("cornell-box"), params), "");
}

}  // namespace
}  // namespace photond::beam_sizes_test
