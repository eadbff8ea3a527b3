// Virtual lights on the device are the CPU's, light for light: the same texels, choice, paths and order, but for
// rounding.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <mutex>

#include "renderer/backends/gpu/counters.h"
#include "renderer/many_lights/flux_map.h"
#include "renderer/many_lights/incremental_vpls.h"
#include "renderer/many_lights/vpl_tracer_gpu.h"
#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/voxels/sparse_voxel_octree_gpu.h"
#include "renderer/voxels/voxel_intersector.h"
#include "tests/support/gpu_render.h"
#include "tests/support/photons.h"
#include "tests/support/scene_parts.h"

namespace photond::gpu_vpl_tracer_test {
namespace {

constexpr uint64_t kSeed = 5;
constexpr uint32_t kPass = 3;

struct DeviceLights {
    std::vector<ReflectedPhoton> photons;
    std::vector<ReflectingSurface> surfaces;
    std::vector<ReflectedPhoton> texels;
    std::vector<float> importance;
    Counts counts;
};

/// `halved`: the importance of the map's first half, along its curve, is made 0 in between.
DeviceLights trace_on_device(const test::SceneOnDevice& where, const EmissionSampler& emission,
                             const VplTracing& tracing, bool halved = false, uint32_t passes = 1,
                             const VplBounceShader& bounces = {}, const ChosenPaths* paths = nullptr) {
    gpu::Device& device = test::gpu_device();
    gpu::Counters counters(device);
    VplTracerGpu tracer(where.device_scene, emission, tracing, counters.buffer(), halved, bounces);
    gpu::CommandList commands(device);
    DeviceLights lights;
    if (paths) tracer.start(kSeed, *paths);
    for (uint32_t pass = kPass + 1 - passes; pass <= kPass; ++pass) {  // what passes before left must not matter
        commands.reset();
        counters.record_clear(commands);
        tracer.start(kSeed, pass);
        tracer.record_map(commands);
        if (halved) commands.fill(tracer.importance(), 0, 0, tracer.map_texels() / 2 * sizeof(float));
        tracer.record_vpls(commands);
        counters.record_readback(commands);
        commands.submit();
        commands.wait();
    }
    counters.read(lights.counts);
    tracer.add_to(lights.counts);
    const uint32_t count = gpu::read_back<uint32_t>(device, tracer.state(), REFLECTION_STATE_WORDS)[REFLECTION_PHOTONS];
    EXPECT_LE(count, tracer.most_lights());
    const auto records = gpu::read_back<ReflectedPhoton>(device, tracer.photons(), count);
    for (const uint32_t i : gpu::read_back<uint32_t>(device, tracer.order(), count))
        lights.photons.push_back(records[i]);
    lights.surfaces = gpu::read_back<ReflectingSurface>(device, tracer.surfaces(),
                                                        tracer.surfaces().bytes() / sizeof(ReflectingSurface));
    lights.texels = gpu::read_back<ReflectedPhoton>(device, tracer.texels(), tracer.map_texels());
    lights.importance = gpu::read_back<float>(device, tracer.importance(), tracer.map_texels());
    return lights;
}

TracedReflections trace_on_cpu(const test::PhotonScene& lit, const VplTracing& tracing,
                               const TexelImportance& importance = {}) {
    Stats stats;
    return VplTracer(lit.scene, *lit.intersector, *lit.intersector, lit.emission, tracing)
        .trace(kSeed, kPass, importance, stats, CancelToken{});
}

bool near(const vec3& a, const vec3& b, float tolerance) { return glm::length(a - b) <= tolerance; }

bool alike(const ReflectedPhoton& a, const ReflectedPhoton& b, float scene_m) {
    return near(a.position, b.position, 1e-4f * scene_m) && near(a.normal, b.normal, 1e-3f) &&
           near(a.direction, b.direction, 2e-3f) && near(a.power_w, b.power_w, 2e-3f * glm::length(a.power_w)) &&
           std::fabs(a.correction - b.correction) < 2e-3f && a.scatterings_and_spread == b.scatterings_and_spread &&
           (a.surface == ReflectedPhoton::kNoSurface) == (b.surface == ReflectedPhoton::kNoSurface);
}

/// Both lists side by side; where one has a light that the other lacks the next that are alike go on. The share of all
/// that have none.
double share_alone(const TracedReflections& cpu, const DeviceLights& gpu, float scene_m) {
    size_t i = 0, k = 0, alone = 0;
    while (i < cpu.photons.size() && k < gpu.photons.size()) {
        if (alike(cpu.photons[i], gpu.photons[k], scene_m)) {
            if (cpu.photons[i].surface != ReflectedPhoton::kNoSurface) {
                const ReflectingSurface& a = cpu.surfaces[cpu.photons[i].surface];
                const ReflectingSurface& b = gpu.surfaces[gpu.photons[k].surface];
                EXPECT_EQ(a.hit.instance, b.hit.instance);
                EXPECT_TRUE(near(a.wi_world, b.wi_world, 1e-3f));
                EXPECT_TRUE(near(a.arriving_power_w, b.arriving_power_w, 2e-3f * glm::length(a.arriving_power_w)));
                EXPECT_NEAR(a.outside_ior, b.outside_ior, 1e-5f);
            }
            ++i, ++k;
            continue;
        }
        ++alone;
        size_t skip = 1;  // nearest place where they agree again
        bool found = false;
        for (; skip < 8 && !found; ++skip)
            for (size_t of_cpu = 0; of_cpu <= skip && !found; ++of_cpu) {
                const size_t a = i + of_cpu, b = k + skip - of_cpu;
                if (a < cpu.photons.size() && b < gpu.photons.size() && alike(cpu.photons[a], gpu.photons[b], scene_m))
                    i = a, k = b, found = true;
            }
        if (!found) ++i, ++k;
    }
    return double(alone) / double(std::max(cpu.photons.size(), size_t{1}));
}

class GpuVplTracer : public testing::TestWithParam<const char*> {};

// Paths that rounding sent elsewhere are different, and what they left after: up to 2 %.
TEST_P(GpuVplTracer, LightsAreTheCpus) {
    const Scene scene = test::turned(make_builtin_scene(GetParam()));
    const test::PhotonScene lit(scene);
    const test::SceneOnDevice where(scene);
    for (const uint32_t bounces : {1u, 3u}) {
        if (bounces == 1 && !scene.needs.only_lambert()) continue;  // pipelines take a software device seconds
        SCOPED_TRACE(bounces);
        const VplTracing tracing{.vpls = 600, .map_side = 32, .bounces = bounces};
        const TracedReflections cpu = trace_on_cpu(lit, tracing);
        const DeviceLights gpu = trace_on_device(where, lit.emission, tracing, false, 2);
        ASSERT_GT(cpu.photons.size(), 300u);
        EXPECT_NEAR(double(gpu.photons.size()), double(cpu.photons.size()), 0.01 * double(cpu.photons.size()));
        EXPECT_LT(share_alone(cpu, gpu, scene.bounds.radius()), 0.02);
        EXPECT_EQ(cpu.counts.photons_emitted, gpu.counts.photons_emitted);
        EXPECT_EQ(gpu.photons.size(), gpu.counts.photons_stored);
        EXPECT_NEAR(double(cpu.counts.photon_rays), double(gpu.counts.photon_rays),
                    0.01 * double(gpu.counts.photon_rays));
    }
}
// Paths that are given instead (incremental_vpls.h), those of some slots missing.
TEST(GpuVplTracerPaths, LightsOfGivenPathsAreTheCpus) {
    const Scene scene = test::turned(make_builtin_scene("cornell-box"));
    const test::PhotonScene lit(scene);
    const test::SceneOnDevice where(scene);
    const VplTracing tracing{.vpls = 300, .map_side = 32, .bounces = 3};
    const VplTracer tracer(scene, *lit.intersector, *lit.intersector, lit.emission, tracing);
    VplsBetweenFrames frames({.on = true}, tracing.vpls);
    Stats stats;
    MemoryBudget budget;
    frames.renew(tracer, lit.emission, {scene, lit.intersector.get(), {}, kSeed, budget}, stats);
    ChosenPaths paths = frames.paths();
    for (uint32_t slot = 0; slot < tracing.vpls; slot += 7) paths.starts[slot] = {};
    const TracedReflections cpu = tracer.trace(kSeed, paths, stats, CancelToken{});
    const DeviceLights gpu = trace_on_device(where, lit.emission, tracing, false, 2, {}, &paths);
    ASSERT_GT(cpu.photons.size(), 200u);
    EXPECT_NEAR(double(gpu.photons.size()), double(cpu.photons.size()), 0.01 * double(cpu.photons.size()));
    EXPECT_LT(share_alone(cpu, gpu, scene.bounds.radius()), 0.02);
}
INSTANTIATE_TEST_SUITE_P(BuiltinScenes, GpuVplTracer,
                         testing::Values("cornell-box", "cornell-box-glass", "cornell-box-glossy", "interior"),
                         [](const auto& info) { return test::test_name(info.param, info.index); });

/// Two lights of very different power, and many weak ones, over a floor.
Scene floor_with_lights(uint32_t weak) {
    Scene scene;
    add_mesh(scene, MeshBuilder()
                        .quad({-3, 0, 3}, {3, 0, 3}, {3, 0, -3}, {-3, 0, -3})
                        .build(add_material(scene, lambert("floor", Rgb(0.5f, 0.4f, 0.3f)))));
    for (uint32_t i = 0; i < weak + 2; ++i) {
        PunctualLight light;
        light.kind = i % 3 == 0   ? PunctualLight::Kind::Spot
                     : i % 3 == 1 ? PunctualLight::Kind::Directional
                                  : PunctualLight::Kind::Point;
        light.position = {0.01f * static_cast<float>(i % 100), 2, 0.001f * static_cast<float>(i)};
        light.direction = {0, -1, 0};
        light.intensity = Rgb(i < 2 ? 5.0f : 1e-4f * static_cast<float>(i));
        scene.punctual_lights.push_back(light);
    }
    finish_scene(scene);
    return scene;
}

// What the map's texels see, what they are worth, and weak lights in their turns.
TEST(GpuVplTracer, TexelsAreTheCpus) {
    const Scene scene = floor_with_lights(2'000);
    const test::PhotonScene lit(scene);
    const test::SceneOnDevice where(scene);
    const VplTracing tracing{.vpls = 500, .map_side = 32};
    std::vector<ReflectedPhoton> seen;
    std::mutex mutex;
    const TracedReflections cpu = trace_on_cpu(lit, tracing, [&](const ReflectedPhoton& photon) {
        const std::lock_guard lock(mutex);
        seen.push_back(photon);
        return 1.0f;
    });
    const DeviceLights gpu = trace_on_device(where, lit.emission, tracing, false, 3);
    EXPECT_LT(share_alone(cpu, gpu, scene.bounds.radius()), 0.02);
    size_t lit_texels = 0, alone = 0;
    for (size_t i = 0; i < gpu.texels.size(); ++i) {
        const ReflectedPhoton& texel = gpu.texels[i];
        EXPECT_EQ(is_black(texel.power_w), gpu.importance[i] == 0);
        if (is_black(texel.power_w)) continue;
        ++lit_texels;
        EXPECT_NEAR(gpu.importance[i], max_component(texel.power_w), 1e-5f * gpu.importance[i]);
        alone += std::none_of(seen.begin(), seen.end(),
                              [&](const ReflectedPhoton& other) { return alike(texel, other, scene.bounds.radius()); });
    }
    EXPECT_GT(lit_texels, 300u);
    EXPECT_NEAR(double(lit_texels), double(seen.size()), 3);
    EXPECT_LE(alone, 3u);
}

// The first half of the map is left a quarter of the lights; with all powers the flux is the same.
TEST(GpuVplTracer, FollowsAnImportance) {
    const Scene scene = make_builtin_scene("cornell-box-spot");
    const test::PhotonScene lit(scene);
    const test::SceneOnDevice where(scene);
    const VplTracing tracing{.vpls = 800, .map_side = 32};
    const DeviceLights all = trace_on_device(where, lit.emission, tracing);
    // The same on the CPU: texels are told apart by where they are.
    std::vector<vec3> first_half;
    for (size_t i = 0; i < all.texels.size() / 2; ++i) first_half.push_back(all.texels[i].position);
    const TracedReflections cpu = trace_on_cpu(lit, tracing, [&](const ReflectedPhoton& photon) {
        return std::any_of(first_half.begin(), first_half.end(),
                           [&](const vec3& p) { return near(p, photon.position, 1e-5f); })
                   ? 0.0f
                   : 1.0f;
    });
    const DeviceLights gpu = trace_on_device(where, lit.emission, tracing, true);
    EXPECT_LT(share_alone(cpu, gpu, scene.bounds.radius()), 0.02);
    const float most = max_component(all.photons[0].power_w);
    const auto strong = std::count_if(gpu.photons.begin(), gpu.photons.end(),
                                      [&](const ReflectedPhoton& p) { return max_component(p.power_w) > 1.5f * most; });
    EXPECT_GT(strong, 50);
    EXPECT_LT(strong, 250);
}

// Hits after the first found in a voxel tree, first ones by rays: also the second lights are the CPU's.
TEST(GpuVplTracer, BouncesByVoxelsAreTheCpus) {
    const Scene scene = test::turned(make_builtin_scene("cornell-box"));
    const test::PhotonScene lit(scene);
    const test::SceneOnDevice where(scene);
    const VoxelGrid grid = make_voxel_grid(scene.bounds, 64);
    const SparseVoxelOctree cpu_tree(scene, grid, true);
    const VoxelIntersector voxels(scene, cpu_tree);
    SparseVoxelOctreeGpu tree(where.device_scene, grid, true);
    Stats stats;
    tree.build_now(stats);
    const VplTracing tracing{.vpls = 600, .map_side = 32, .bounces = 3};
    const TracedReflections cpu =
        VplTracer(scene, *lit.intersector, voxels, lit.emission, tracing).trace(kSeed, kPass, {}, stats, CancelToken{});
    const DeviceLights gpu = trace_on_device(
        where, lit.emission, tracing, false, 1,
        {.name = "renderer/methods/svo_many_lights/vpl_bounces_voxels.comp",
         .bindings = {gpu::read("svo_constants", tree.constants()), gpu::read("svo_nodes", tree.nodes()),
                      gpu::read("svo_bricks", tree.bricks()), gpu::read("svo_surfaces", tree.surfaces()),
                      gpu::read("svo_first_triangles", tree.first_triangles())}});
    ASSERT_GT(cpu.photons.size(), 800u);
    EXPECT_LT(share_alone(cpu, gpu, scene.bounds.radius()), 0.03);
    // Biased as voxels are, but by voxels: not the rays' own lights, and no other number of them.
    const TracedReflections by_rays = trace_on_cpu(lit, tracing);
    EXPECT_GT(share_alone(by_rays, gpu, scene.bounds.radius()), 0.05);
    EXPECT_NEAR(double(gpu.photons.size()), double(by_rays.photons.size()), 0.05 * double(by_rays.photons.size()));
}

TEST(GpuVplTracer, NothingWithoutLight) {
    Scene dark = floor_with_lights(0), black = dark;
    dark.punctual_lights.clear();
    black.materials[0].base_color = Rgb(0);
    for (Scene* scene : {&dark, &black}) {
        finish_scene(*scene);
        const EmissionSampler emission(*scene);
        const test::SceneOnDevice where(*scene);
        const DeviceLights none = trace_on_device(where, emission, {.vpls = 100, .map_side = 8, .bounces = 2});
        EXPECT_TRUE(none.photons.empty());
        EXPECT_EQ(none.counts.photons_emitted, 100u);
    }
}

// Maps of every size, by one group or many, and one texel.
TEST(GpuVplTracer, PyramidsAreTheCpus) {
    gpu::Device& device = test::gpu_device();
    for (const uint32_t levels : {0u, 1u, 4u, 5u, 9u}) {
        FluxMap cpu(levels);
        RandomStream random(1, RandomDomain::Test, levels, 0);
        for (float& worth : cpu.worth()) worth = std::pow(random.next(), 5.0f) - 0.01f;
        cpu.worth()[0] = levels > 0 ? std::numeric_limits<float>::quiet_NaN() : 2.0f;
        FluxMapGpu gpu(device, levels);
        gpu::upload(device, gpu.sums(), std::as_bytes(std::span<const float>(cpu.worth())));
        gpu::CommandList commands(device);
        gpu.record_sum(commands);
        commands.submit();
        commands.wait();
        cpu.sum();
        const auto sums = gpu::read_back<float>(device, gpu.sums(), FluxMap::values(levels));
        EXPECT_EQ(sums.back(), cpu.total()) << levels;
        for (uint32_t i = 0; i < cpu.texels(); ++i) ASSERT_EQ(sums[i], cpu.worth()[i]);
    }
}

TEST(GpuVplTracer, TakesTheMemoryItSays) {
    for (const auto& [name, weighted] : {std::pair("cornell-box", false), {"cornell-box-glass", true}}) {
        const Scene scene = make_builtin_scene(name);
        const EmissionSampler emission(scene);
        const test::SceneOnDevice where(scene);
        gpu::Device& device = test::gpu_device();
        gpu::Counters counters(device);
        const VplTracing tracing{.vpls = 20'000, .map_side = 128, .bounces = 2};
        const uint64_t before = device.memory().used_bytes();
        const VplTracerGpu tracer(where.device_scene, emission, tracing, counters.buffer(), weighted);
        const uint64_t taken = device.memory().used_bytes() - before;
        const uint64_t said =
            VplTracerGpu::device_bytes(tracing, weighted, scene.needs.only_lambert(), emission.lights());
        EXPECT_LE(taken, said + said / 20 + (64 << 10)) << name;
        EXPECT_GE(taken, said - said / 20) << name;
    }
}

}  // namespace
}  // namespace photond::gpu_vpl_tracer_test
