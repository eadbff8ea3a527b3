// The options built on a photon map: irradiance worked out beforehand, and shadow photons.

#include <gtest/gtest.h>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/core/rng.h"
#include "renderer/photons/precomputed_irradiance.h"
#include "renderer/photons/shadow_photons.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/light_sampling.h"

namespace photond::photon_options_test {
namespace {

std::vector<Photon> scattered_photons(size_t count) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<Photon> photons;
    for (size_t i = 0; i < count; ++i) {
        const vec3 position(random.next(), 0, random.next());
        const vec3 normal(0, i % 3 ? 1.0f : -1.0f, 0);
        photons.push_back({position, PhotonPayload::make(Rgb(random.next(), 1, 2), normal, normal, 1 + uint32_t(i % 4),
                                                         false, i % 4 == 2)});
    }
    return photons;
}

TEST(PrecomputedIrradiance, IsThatOfTheNearestOfItsPhotonsOnTheSameSide) {
    const PhotonMap map(scattered_photons(3000),
                        {.kind = PhotonSearch::Kind::Nearest, .nearest = 20, .radius_m = 0.5f});
    const EstimateSettings settings;
    constexpr uint32_t kMost = 3;
    const PrecomputedIrradiance precomputed(map, settings, kMost);
    EXPECT_EQ(precomputed.size(), map.size() / PHOTONS_A_MARK);
    EXPECT_LE(precomputed.bytes(), PrecomputedIrradiance::bytes_for(map.size()));

    RandomStream random(2, RandomDomain::Test, 0, 0);
    Neighbours scratch;
    int left_to_others = 0;
    for (int q = 0; q < 300; ++q) {
        const vec3 p(random.next(), 0.01f * random.next(), random.next()), normal(0, q % 2 ? 1.0f : -1.0f, 0);
        uint32_t nearest = 0;
        float least = kInfinity;
        for (uint32_t i = 0; i < map.size(); ++i) {
            if (!map.payload(i).marked()) continue;
            const vec3 at = map.position(i), d = at - p;
            if (map.payload(i).normal().y * normal.y <= 0 || glm::dot(d, d) >= least) continue;
            map.find(at, scratch);
            if (glm::dot(d, d) > sqr(scratch.radius_m) || std::fabs(d.y) > 0.25f * scratch.radius_m) continue;
            least = glm::dot(d, d), nearest = i;
        }
        const auto found = precomputed.find(p, normal).found;
        ASSERT_EQ(found.has_value(), least < kInfinity);
        left_to_others += !found;
        if (!found) continue;
        const Rgb expected = estimate_irradiance(map, settings, map.position(nearest), normal, kMost, scratch);
        EXPECT_EQ(found->irradiance, expected);
        EXPECT_EQ(found->radius_m, scratch.radius_m);
    }
    EXPECT_LT(left_to_others, 60);
    const auto expect_nothing = [&](const vec3& p, const vec3& normal, bool is_dark, const char* why) {
        const PrecomputedIrradiance::Lookup lookup = precomputed.find(p, normal);
        EXPECT_FALSE(lookup.found) << why;
        EXPECT_EQ(lookup.is_dark, is_dark) << why;
    };
    expect_nothing({0.5f, 2, 0.5f}, {0, 1, 0}, true, "farther than the search radius");
    expect_nothing({0.5f, 0.03f, 0.5f}, {0, 1, 0}, false, "over the discs, as a table on the floor is");
    expect_nothing({1.2f, 0, 0.5f}, {0, 1, 0}, false, "beside all discs");
    expect_nothing({0.5f, 0, 0.5f}, {1, 0, 0}, true, "no photon faces that way");
    EXPECT_TRUE(PrecomputedIrradiance(PhotonMap(), settings, 1).find({0, 0, 0}, {0, 1, 0}).is_dark);
}

// Something that stands on a floor: photons on its one side, places on its other.
TEST(PrecomputedIrradiance, IsNotTakenThroughAWallButOverALedge) {
    for (const bool wall : {true, false}) {
        const float height = wall ? 1.0f : 0.002f;
        Scene scene;
        scene.materials.emplace_back();
        scene.meshes = {MeshBuilder().quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}).build(0),
                        MeshBuilder().quad({0, 0, -1}, {0, 0, 1}, {0, height, 1}, {0, height, -1}).build(0)};
        scene.instances = {{.mesh = 0}, {.mesh = 1}};
        finish_scene(scene);
        MemoryBudget budget;
        Stats stats;
        const auto intersector = make_embree_intersector(scene, budget, stats);
        std::vector<Photon> photons;
        RandomStream random(3, RandomDomain::Test, 0, 0);
        for (int i = 0; i < 2000; ++i)
            photons.push_back({vec3(-random.next(), 0, 2 * random.next() - 1),
                               PhotonPayload::make(Rgb(1), {0, 1, 0}, {0, 1, 0}, 1, false, i % 4 == 0)});
        constexpr float kRadius = 0.3f;
        const PhotonMap map(photons, {.kind = PhotonSearch::Kind::Nearest, .nearest = 50, .radius_m = kRadius});
        const DiscCoverage coverage(scene, *intersector, kRadius);
        const EstimateSettings whole, clip{.coverage = &coverage};
        const vec3 up(0, 1, 0), behind(0.01f, 0, 0.2f), lit(-0.01f, 0, 0.2f);
        EXPECT_TRUE(PrecomputedIrradiance(map, whole, 9).find(behind, up).found) << "whole discs see no wall";
        const PrecomputedIrradiance precomputed(map, clip, 9);
        EXPECT_EQ(precomputed.find(behind, up).found.has_value(), !wall);
        EXPECT_TRUE(precomputed.find(lit, up).found);
    }
}

// Of even light the mean is its irradiance, though each photon counts on its own disc: the emptiness about a place
// whose nearest photon that is makes up for it.
TEST(PrecomputedIrradiance, HasNoBiasInEvenLight) {
    constexpr int kMaps = 24, kPhotons = 6000, kPlaces = 4000;
    const EstimateSettings settings;
    double sum = 0, sum_sq = 0;
    for (uint32_t m = 0; m < kMaps; ++m) {
        RandomStream random(7, RandomDomain::Test, m, 0);
        std::vector<Photon> photons;
        for (int i = 0; i < kPhotons; ++i)
            photons.push_back({vec3(random.next(), 0, random.next()),
                               PhotonPayload::make(Rgb(1.0f / kPhotons), {0, 1, 0}, {0, 1, 0}, 1, false, i % 4 == 0)});
        const PhotonMap map(photons, {.kind = PhotonSearch::Kind::Nearest, .nearest = 50, .radius_m = 0.5f});
        const PrecomputedIrradiance precomputed(map, settings, 9);
        double mean = 0;
        for (int i = 0; i < kPlaces; ++i) {  // away from the edge
            const auto found =
                precomputed.find({0.15f + 0.7f * random.next(), 0, 0.15f + 0.7f * random.next()}, {0, 1, 0}).found;
            mean += (found ? found->irradiance.x : 0.0) / kPlaces;
        }
        sum += mean / kMaps;
        sum_sq += mean * mean / kMaps;
    }
    // False alarms: 1e-6, by Student's t of 23 degrees of freedom.
    EXPECT_NEAR(sum, 1, 6.6 * std::sqrt((sum_sq - sum * sum) / (kMaps - 1)));
}

/// A floor under a small lamp, a plate between them.
struct ShadowScene {
    Scene scene;
    std::unique_ptr<Intersector> intersector;

    ShadowScene() {
        Material white, lamp;
        white.metallic = lamp.metallic = 0;
        lamp.emission = Rgb(1);
        scene.materials = {white, lamp};
        scene.meshes = {
            MeshBuilder()
                .quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2})
                .quad({-1, 1, 1}, {0, 1, 1}, {0, 1, -1}, {-1, 1, -1})
                .build(0),
            MeshBuilder().quad({-0.1f, 2, -0.1f}, {0.1f, 2, -0.1f}, {0.1f, 2, 0.1f}, {-0.1f, 2, 0.1f}).build(1)};
        scene.instances = {{.mesh = 0}, {.mesh = 1}};
        finish_scene(scene);
        MemoryBudget budget;
        Stats stats;
        intersector = make_embree_intersector(scene, budget, stats);
    }
};

TEST(ShadowPhotons, TellLightFromShadowAndLeaveTheBorderOpen) {
    const ShadowScene world;
    const EmissionSampler emission(world.scene);
    Counts counts;
    const ShadowPhotons photons(world.scene, *world.intersector, emission, 50'000, 0.1f, 1, 0, CancelToken{}, counts);
    EXPECT_EQ(counts.photons_emitted, 50'000u);
    // 66 % of the lamp's light meets the floor or the plate (a form factor); what meets the plate meets the floor
    // again.
    EXPECT_GT(counts.photons_stored, 33'000u);
    EXPECT_GE(counts.photon_rays, counts.photons_stored);
    Neighbours scratch;
    const uint32_t lamp = light_source_of_instance(1);
    EXPECT_EQ(photons.seen({0.7f, 0, 0}, {0, 1, 0}, lamp, scratch), LightSeen::Whole);
    EXPECT_EQ(photons.seen({-1.0f, 0, 0}, {0, 1, 0}, lamp, scratch), LightSeen::Nothing);
    EXPECT_EQ(photons.seen({0.0f, 0, 0}, {0, 1, 0}, lamp, scratch), LightSeen::Unknown) << "the plate's edge";
    EXPECT_EQ(photons.seen({0.7f, 0, 0}, {0, -1, 0}, lamp, scratch), LightSeen::Unknown) << "no photon from below";
    EXPECT_EQ(photons.seen({0.7f, 0, 0}, {0, 1, 0}, light_source_of_instance(0), scratch), LightSeen::Unknown);
    EXPECT_EQ(photons.seen({0.7f, 3, 0}, {0, 1, 0}, lamp, scratch), LightSeen::Unknown) << "nothing near";
}

TEST(ShadowPhotons, AgreeWithShadowRaysAwayFromBorders) {
    const ShadowScene world;
    const EmissionSampler emission(world.scene);
    const LightSampler lights(world.scene);
    Counts counts;
    const ShadowPhotons photons(world.scene, *world.intersector, emission, 50'000, 0.1f, 1, 0, CancelToken{}, counts);
    RandomStream random(3, RandomDomain::Test, 0, 0);
    Neighbours scratch;
    size_t decided = 0, wrong = 0, asked = 0;
    for (int i = 0; i < 4000; ++i) {
        const vec3 p(2 * random.next() - 1, 0, 2 * random.next() - 1), n(0, 1, 0);
        LightSample light;
        const float u_select = random.next();
        if (!lights.sample(p, n, u_select, random.next_2d(), light)) continue;
        const LightSeen seen = photons.seen(p, n, light.source, scratch);
        ++asked;
        if (seen == LightSeen::Unknown) continue;
        ++decided;
        wrong += (seen == LightSeen::Nothing) != world.intersector->occluded(light.shadow_ray(offset_ray_origin(p, n)));
    }
    // About 30 photons lie within the radius: penumbra points at which all of them agree against the ray are few.
    EXPECT_GT(decided, asked / 2);
    EXPECT_LE(double(wrong), 0.005 * double(decided));
}

}  // namespace
}  // namespace photond::photon_options_test
