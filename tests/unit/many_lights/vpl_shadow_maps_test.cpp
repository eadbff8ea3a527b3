// Depth maps of virtual lights against shadow rays, and where the answer is known.

#include "renderer/many_lights/vpl_shadow_maps.h"

#include <gtest/gtest.h>

#include <string>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/sampling.h"
#include "tests/support/scene_parts.h"
#include "tests/support/vpls.h"

namespace photond::vpl_shadow_maps_test {
namespace {

/// Over the floor y = 0 a plate in y = 1, both seen by a light at the origin that looks up.
Scene floor_and_plate() {
    Scene scene;
    MeshBuilder plate;
    plate.quad({-0.5f, 1, -0.5f}, {0.5f, 1, -0.5f}, {0.5f, 1, 0.5f}, {-0.5f, 1, 0.5f});
    test::add(scene, plate.build(0), test::lambert(0.5f));
    finish_scene(scene);
    return scene;
}

TEST(VplMap, PlacesAndDirectionsAreInverse) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 1000; ++i) {
        const vec3 w = sample_cosine_hemisphere(random.next_2d());
        EXPECT_NEAR(glm::dot(vpl_map::direction(vpl_map::place(3.0f * w)), w), 1, 1e-6);
    }
    for (const uint32_t resolution : {4u, 13u, 128u})
        for (uint32_t texel = 0; texel < resolution * resolution; ++texel) {
            const vec3 centre = vpl_map::texel_direction(texel, resolution);
            EXPECT_GT(centre.z, 0);
            EXPECT_EQ(vpl_map::texel(vpl_map::place(centre), resolution), texel);
        }
}

TEST(VplMap, PlanesReachTheirFarthestCorner) {
    // Straight on, the middle of the map: the texels' corners lie farther by 1 / cos.
    constexpr uint32_t kResolution = 8, kTexel = 3 * kResolution + 4;
    const vec3 centre = vpl_map::texel_direction(kTexel, kResolution);
    float farthest = 0;
    for (const vec2 corner : {vec2(4, 3), vec2(5, 3), vec2(4, 4), vec2(5, 4)})
        farthest = std::max(farthest, 1 / vpl_map::direction(corner / 8.0f).z);
    const float reach = vpl_map::reach_m(kTexel, kResolution, 1 / centre.z, {0, 0, 1});
    EXPECT_GT(reach, farthest);
    EXPECT_LT(reach, farthest + 1.01f * vpl_map::kTolerance * 0.3f / centre.z) << "a texel is 0.25 wide, at the pole";
    EXPECT_EQ(vpl_map::reach_m(kTexel, kResolution, 1 / centre.z, {0, 0, -1}), reach) << "whichever side";
    // Along a plane: no farther than the cap.
    const vec3 along = glm::normalize(glm::cross(centre, vec3(0.3f, 1, 0)));
    EXPECT_LE(vpl_map::reach_m(kTexel, kResolution, 1, glm::normalize(along + 1e-4f * centre)),
              vpl_map::kMostStretch + vpl_map::kTolerance * 0.4f);
}

TEST(VplShadowMaps, KnowAPlateTexelByTexel) {
    const Scene scene = floor_and_plate();
    MemoryBudget budget;
    Stats stats;
    const auto intersector = make_embree_intersector(scene, budget, stats);
    const gpu::Vpl vpl{.position = {0, 0, 0}, .normal = {0, 1, 0}, .intensity = vec3(1), .surface = NO_VPL_SURFACE};
    for (const uint32_t resolution : {4u, 15u, 64u}) {
        VplShadowMaps maps(resolution);
        maps.build({&vpl, 1}, scene, *intersector, stats);
        const Frame axes(vpl.normal);
        size_t covered = 0;
        for (uint32_t texel = 0; texel < resolution * resolution; ++texel) {
            const vec3 w = axes.to_world(vpl_map::texel_direction(texel, resolution));
            const float distance_m = 1 / w.y;
            const bool on_plate = std::fabs(w.x) < 0.5f * w.y && std::fabs(w.z) < 0.5f * w.y;
            covered += on_plate;
            EXPECT_FALSE(maps.occluded(0, 0.5f * distance_m * w));
            EXPECT_FALSE(maps.occluded(0, distance_m * w)) << "the plate itself";
            EXPECT_EQ(maps.occluded(0, 5.0f * distance_m * w), on_plate);
            EXPECT_EQ(std::isinf(maps.reach_m()[texel]), !on_plate);
        }
        EXPECT_GT(covered, 0u);
        EXPECT_LT(2 * covered, resolution * resolution);
        EXPECT_TRUE(maps.occluded(0, {0.1f, -0.1f, 0})) << "behind the light's surface";
    }
}

/// No point of a plane that light falls on down to 6 degrees is shadowed by the plane.
TEST(VplShadowMaps, PlanesDoNotShadowThemselves) {
    Scene scene;
    MeshBuilder floor;
    floor.quad({-200, 0, -200}, {-200, 0, 200}, {200, 0, 200}, {200, 0, -200});
    test::add(scene, floor.build(0), test::lambert(0.5f));
    finish_scene(scene);
    MemoryBudget budget;
    Stats stats;
    const auto intersector = make_embree_intersector(scene, budget, stats);
    RandomStream random(2, RandomDomain::Test, 0, 0);
    std::vector<gpu::Vpl> vpls;
    for (const vec3 normal : {vec3(0, -1, 0), vec3(1, 0, 0), vec3(0.6f, -0.64f, 0.48f), vec3(0.48f, 0.6f, -0.64f)})
        vpls.push_back({.position = {0, 1, 0}, .normal = normal, .surface = NO_VPL_SURFACE});
    for (const uint32_t resolution : {16u, 32u, 128u}) {
        VplShadowMaps maps(resolution);
        maps.build(vpls, scene, *intersector, stats);
        size_t asked = 0;
        for (int i = 0; i < 20000; ++i) {
            const float tangent = 10 * random.next(), angle = 2 * kPi * random.next();
            const vec3 point(tangent * std::cos(angle), 0, tangent * std::sin(angle));
            for (size_t light = 0; light < vpls.size(); ++light) {
                if (glm::dot(point - vpls[light].position, vpls[light].normal) <= 0) continue;
                ++asked;
                EXPECT_FALSE(maps.occluded(light, point)) << resolution << " light " << light << " at " << tangent;
            }
        }
        EXPECT_GT(asked, 30000u);
    }
}

double wrong_share(const Scene& scene, uint32_t resolution) {
    MemoryBudget budget;
    Stats stats;
    const auto intersector = make_embree_intersector(scene, budget, stats);
    const std::vector<gpu::Vpl> vpls = test::vpls_on(scene, *intersector, 100, 1);
    const std::vector<gpu::Vpl> points = test::vpls_on(scene, *intersector, 2000, 2);
    VplShadowMaps maps(resolution);
    maps.build(vpls, scene, *intersector, stats);
    return test::wrong_share(scene, *intersector, vpls, points,
                             [&](size_t light, const vec3& point) { return maps.occluded(light, point); });
}

TEST(VplShadowMaps, ErrLessTheFinerTheyAre) {
    // Edges are what they err at: a box with two blocks has few, a furnished room many.
    for (const auto& [name, most] : {std::pair("cornell-box", 0.005), std::pair("interior", 0.03)}) {
        const Scene scene = make_builtin_scene(name);
        double before = 1;
        for (const uint32_t resolution : {8u, 16u, 32u, 64u, 128u}) {
            const double wrong = wrong_share(scene, resolution);
            RecordProperty(name + ("-" + std::to_string(resolution)), std::to_string(wrong));
            EXPECT_LT(wrong, 0.75 * before) << name << " " << resolution;
            before = wrong;
        }
        EXPECT_LT(before, most) << name;
    }
}

TEST(VplShadowMaps, TakeTheMemoryTheySayAndNoneForNoLights) {
    const Scene scene = floor_and_plate();
    MemoryBudget budget;
    Stats stats;
    const auto intersector = make_embree_intersector(scene, budget, stats);
    const std::vector<gpu::Vpl> vpls(100, gpu::Vpl{.normal = {0, 1, 0}, .surface = NO_VPL_SURFACE});
    VplShadowMaps maps(16);
    maps.build({}, scene, *intersector, stats);
    EXPECT_EQ(maps.bytes(), 0u);
    maps.build(vpls, scene, *intersector, stats);
    EXPECT_EQ(maps.bytes(), VplShadowMaps::bytes_for(100, 16));
    EXPECT_EQ(stats.counts.shadow_rays, 100u * 256);
}

}  // namespace
}  // namespace photond::vpl_shadow_maps_test
