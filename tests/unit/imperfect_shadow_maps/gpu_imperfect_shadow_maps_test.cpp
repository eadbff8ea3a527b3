// Depth maps from points: the points, the maps against rays, and the method against others.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "protocol/param_json.h"
#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/backends/gpu/counters.h"
#include "renderer/many_lights/imperfect_shadow_maps.h"
#include "renderer/many_lights/occluder_points.h"
#include "renderer/many_lights/vpl_shadow_maps.h"
#include "renderer/methods/imperfect_shadow_maps/imperfect_shadow_maps_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/surface_area.h"
#include "tests/support/block_test.h"
#include "tests/support/gpu_render.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/open_scene.h"
#include "tests/support/path_render.h"
#include "tests/support/vpls.h"

namespace photond::gpu_imperfect_shadow_maps_test {
namespace {

/// Of some lights of a scene, on the host.
struct Maps {
    uint32_t resolution;
    std::vector<gpu::Vpl> vpls;
    std::vector<float> reach_m;
    float disc_radius_m;

    bool occluded(size_t light, const vec3& point) const {
        const vec3 local = Frame(vpls[light].normal).to_local(point - vpls[light].position);
        if (!(local.z > 0)) return true;
        const uint32_t texel = vpl_map::texel(vpl_map::place(local), resolution);
        return glm::length(local) > reach_m[light * resolution * resolution + texel];
    }
};

Maps imperfect_maps(const Scene& scene, std::vector<gpu::Vpl> vpls, uint32_t resolution, uint32_t points) {
    gpu::Device& device = test::gpu_device();
    const gpu::DeviceScene device_scene(device, scene);
    gpu::Counters counters(device);
    const auto count = static_cast<uint32_t>(vpls.size());
    VplShadowMapsGpu maps(device_scene, resolution, count, counters.buffer());
    ImperfectShadowMaps imperfect(device_scene, maps, points);
    gpu::Buffer device_vpls = gpu::make_buffer(device, "test vpls", std::span<const gpu::Vpl>(vpls));
    gpu::Buffer device_count = gpu::make_buffer(device, "test count", std::span(&count, 1));
    for (uint32_t piece = 0; piece < imperfect.pieces(); ++piece) {
        gpu::CommandList commands(device);
        imperfect.record(commands, device_vpls, device_count, 1, 0, piece);
        commands.submit();
        commands.wait();
    }
    return {resolution, std::move(vpls), gpu::read_back<float>(device, maps.reach(), maps.reach().bytes() / 4),
            imperfect.disc_radius_m()};
}

TEST(OccluderPoints, LieOnTheTrianglesByTheirArea) {
    const Scene scene = make_builtin_scene("cornell-box");
    constexpr uint32_t kCount = 20000;
    const std::vector<gpu::OccluderPoint> points = make_occluder_points(scene, kCount);
    ASSERT_EQ(points.size(), kCount);
    const double area_m2 = surface_area_m2(scene);
    size_t found = 0;
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        for (uint32_t t = 0; t < scene.meshes[scene.instances[i].mesh].triangles.size(); ++t) {
            const TriangleCorners at = world_triangle(scene, i, t);
            const vec3 cross = glm::cross(at.p[1] - at.p[0], at.p[2] - at.p[0]);
            const double expected = kCount * 0.5 * double{glm::length(cross)} / area_m2;
            // They come triangle after triangle.
            size_t here = 0;
            for (; found < kCount; ++found, ++here) {
                const vec3 off = points[found].position - at.p[0];
                const vec3 n = cross / glm::dot(cross, cross);
                const float u = glm::dot(n, glm::cross(off, at.p[2] - at.p[0]));
                const float v = glm::dot(n, glm::cross(at.p[1] - at.p[0], off));
                const bool on_plane = std::fabs(glm::dot(off, glm::normalize(cross))) < 1e-4f * scene.bounds.radius();
                if (!(on_plane && u > -1e-4f && v > -1e-4f && u + v < 1 + 1e-4f)) break;
                if (static_cast<double>(here) > expected + 1) break;  // of one beside it in the same plane
                EXPECT_NEAR(std::fabs(glm::dot(points[found].normal, glm::normalize(cross))), 1, 1e-5);
            }
            EXPECT_NEAR(static_cast<double>(here), expected, 2) << i << " " << t;
        }
    EXPECT_EQ(found, kCount);
    EXPECT_TRUE(make_occluder_points(Scene{}, 100).empty());
}

TEST(OccluderPoints, AreNoneWhereAMaskLeavesNoSurface) {
    Scene scene;
    MeshBuilder leaf;
    leaf.quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
    Material material = test::lambert(0.5f);
    material.alpha_mode = AlphaMode::Blend;
    material.alpha = 0.25f;
    test::add(scene, leaf.build(0), material);
    finish_scene(scene);
    const std::vector<gpu::OccluderPoint> points = make_occluder_points(scene, 10000);
    const auto there = std::count_if(points.begin(), points.end(), [](const auto& p) { return p.normal != vec3(0); });
    EXPECT_NEAR(double(there), 2500, 5 * std::sqrt(10000 * 0.25 * 0.75)) << "false alarms 6e-7";
}

TEST(GpuImperfectShadowMaps, AreAboutTheTracedOnesAndBetterByMorePoints) {
    for (const auto& [name, most] : {std::pair("cornell-box", 0.06), std::pair("interior", 0.25)}) {
        const Scene scene = make_builtin_scene(name);
        MemoryBudget budget;
        Stats stats;
        const auto intersector = make_embree_intersector(scene, budget, stats);
        const std::vector<gpu::Vpl> vpls = test::vpls_on(scene, *intersector, 40, 1);
        const std::vector<gpu::Vpl> points = test::vpls_on(scene, *intersector, 1000, 2);
        double before = 1;
        for (const uint32_t discs : {256u, 4096u}) {
            const Maps maps = imperfect_maps(scene, vpls, 32, discs);
            const double wrong =
                test::wrong_share(scene, *intersector, vpls, points,
                                  [&](size_t light, const vec3& point) { return maps.occluded(light, point); });
            RecordProperty(name + ("-" + std::to_string(discs)), std::to_string(wrong));
            EXPECT_LT(wrong, before) << name << " " << discs;
            before = wrong;
        }
        EXPECT_LT(before, most) << name;
    }
}

TEST(GpuImperfectShadowMaps, HolesAreClosedWhereSurfacesAre) {
    // Inside a closed box each texel meets a wall.
    Scene scene;
    MeshBuilder box;
    box.box({-1, -1, -1}, {1, 1, 1});
    test::add(scene, box.build(0), test::lambert(0.5f));
    finish_scene(scene);
    const gpu::Vpl vpl{.position = {0, -0.999f, 0}, .normal = {0, 1, 0}, .surface = NO_VPL_SURFACE};
    const Maps maps = imperfect_maps(scene, {vpl}, 32, 512);
    EXPECT_EQ(std::count_if(maps.reach_m.begin(), maps.reach_m.end(), [](float m) { return std::isinf(m); }), 0);
    EXPECT_FALSE(maps.occluded(0, {0.3f, 0.99f, 0.2f}));
    EXPECT_TRUE(maps.occluded(0, {0.3f, 3, 0.2f}));
}

using Ism = ImperfectShadowMapsGpu;

test::RenderSettingsOf<Ism> settings_for(uint32_t passes) {
    test::RenderSettingsOf<Ism> settings;
    settings.size = {24, 18};
    settings.passes = passes;
    settings.seed = 7;
    settings.params.vpls = 64;
    settings.params.map_resolution = 32;
    settings.params.points = 512;
    settings.params.shadow_resolution = 16;
    settings.params.interleave = 1;
    settings.params.clamp_m2 = 0;
    settings.params.sampler = SamplerKind::Random;
    return settings;
}

/// Where nothing stands between, maps may only shadow falsely: discs, here 0.17 m wide, stand out beyond the edges that
/// face each other (measured: 5 to 6 %).
TEST(GpuImperfectShadowMaps, InTheOpenAreNearlyTheTransportOfOneBounce) {
    for (const char* light : {"spot", "area"}) {
        const Scene scene = test::floor_and_wall(light);
        const test::SceneOnDevice where(scene);
        test::RenderSettings paths_settings;
        paths_settings.size = {24, 18};
        paths_settings.passes = 400;
        paths_settings.params.indirect_bounces = 1;
        paths_settings.params.sampler = SamplerKind::Random;
        const test::RunningMean paths = test::indirect_of_passes(scene, paths_settings);
        const test::RunningMean maps = test::indirect_of_passes(where, settings_for(60));
        const double noise = 5.2 * std::hypot(maps.standard_error(), paths.standard_error());  // false alarms 2e-7
        EXPECT_LT(maps.mean(), paths.mean() + noise) << light;
        EXPECT_GT(maps.mean(), 0.92 * paths.mean() - noise) << light;
        EXPECT_LT(noise, 0.1 * paths.mean()) << "too noisy to notice a defect";
    }
}

TEST(GpuImperfectShadowMaps, SameBitsTwiceInPiecesAndFiltered) {
    const Scene scene = make_builtin_scene("cornell-box-glossy");
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<Ism> settings = settings_for(2);
    settings.params.interleave = 2;
    settings.params.filter = 3;
    settings.params.clamp_m2.reset();
    const Film film = test::render(where, settings);
    EXPECT_EQ(film.pixel_hash(), test::render(where, settings).pixel_hash());
    EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
    EXPECT_GT(test::mean_of_layer(film, Layer::Indirect), 0);
}

// Lights that are placed by what they bring to the picture bring it no more and no less in the mean.
TEST(GpuImperfectShadowMaps, HaveOneMeanWhereverLightsArePlaced) {
    Scene scene = make_builtin_scene("doors/ajar");
    for (Material& material : scene.materials) material.metallic = material.specular = material.transmission = 0;
    for (Mesh& mesh : scene.meshes) mesh.normals.clear();  // the pipelines are those of other cases
    finish_scene(scene);
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<ImperfectShadowMapsGpu> settings;
    settings.size = {32, 24};
    settings.passes = 40;
    settings.params.vpls = 64;
    settings.params.map_resolution = 32;
    settings.params.points = 256;
    settings.params.shadow_resolution = 8;
    settings.params.interleave = 1;
    settings.params.sampler = SamplerKind::Random;
    const auto by_flux = test::render_blocks(where, settings, 8);
    for (const VplPlacement placement : {VplPlacement::Acceptance, VplPlacement::Metropolis}) {
        ++settings.seed;
        settings.params.placement = placement;
        const auto by_worth = test::render_blocks(where, settings, 8);
        const test::BlockTest blocks = test::compare_blocks(by_flux.blocks, by_worth.blocks);
        EXPECT_EQ(blocks.alarms, 0u) << blocks.table();
        EXPECT_LT(blocks.half_notice, 1.0) << blocks.table();
    }
}

TEST(GpuImperfectShadowMaps, DarkScenesAndNoBouncesAreBlack) {
    const Scene dark = test::floor_and_wall("none"), lit = test::floor_and_wall("point");
    for (const Scene* scene : {&dark, &lit}) {
        const test::SceneOnDevice where(*scene);
        test::RenderSettingsOf<Ism> settings = settings_for(2);
        if (scene == &lit) settings.params.bounces = 0;
        const Film film = test::render(where, settings);
        EXPECT_EQ(test::mean_of_layer(film, Layer::Indirect), 0);
        EXPECT_EQ(test::mean_of_layer(film, Layer::Direct) > 0, scene == &lit);
    }
    ImperfectShadowMapsParams params;
    std::vector<Fault> faults;
    read_params(params, {{"bounces", 2}}, "", faults);
    ASSERT_EQ(faults.size(), 1u) << "one bounce is all it does";
    EXPECT_EQ(faults[0].pointer, "/bounces");
}

TEST(GpuImperfectShadowMaps, TakeTheMemoryTheySay) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<Ism> settings = settings_for(1);
    settings.size = {160, 120};
    settings.params.vpls = 300;
    test::expect_device_bytes_as_estimated(where, settings);

    MemoryBudget budget;
    Stats stats;
    Ism method(settings.params);
    method.begin({scene, &where.intersector, test::view_of(scene, settings), 1, budget, &where.device_scene}, stats);
    const auto estimate = double(Ism::estimate_bytes(settings.params, test::workload_of(scene, settings)));
    EXPECT_LE(double(budget.accounted_bytes()), 1.5 * estimate);
    EXPECT_LE(estimate, 1.5 * double(budget.accounted_bytes()));
}

}  // namespace
}  // namespace photond::gpu_imperfect_shadow_maps_test
