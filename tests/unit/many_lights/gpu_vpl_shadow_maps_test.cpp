// Depth maps of virtual lights on the device against those of the CPU, texel by texel and answer by answer.

#include <gtest/gtest.h>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/backends/gpu/counters.h"
#include "renderer/many_lights/vpl_shadow_maps.h"
#include "renderer/many_lights/vpl_shadow_maps_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/vpls.h"

namespace photond::gpu_vpl_shadow_maps_test {
namespace {

struct Question {
    uint32_t light, resolution;
    vec3 point;
};

class GpuVplShadowMaps : public testing::TestWithParam<std::pair<const char*, uint32_t>> {};

TEST_P(GpuVplShadowMaps, AreTheHosts) {
    const auto [name, resolution] = GetParam();
    const Scene scene = make_builtin_scene(name);
    MemoryBudget budget;
    Stats stats;
    const auto intersector = make_embree_intersector(scene, budget, stats);
    const std::vector<gpu::Vpl> vpls = test::vpls_on(scene, *intersector, 20, 1);
    VplShadowMaps host(resolution);
    host.build(vpls, scene, *intersector, stats);

    gpu::Device& device = test::gpu_device();
    const gpu::DeviceScene device_scene(device, scene);
    gpu::Counters counters(device);
    const uint64_t before = device.memory().used_bytes();
    VplShadowMapsGpu maps(device_scene, resolution, 30, counters.buffer());
    const auto taken = static_cast<double>(device.memory().used_bytes() - before);
    EXPECT_NEAR(taken, static_cast<double>(VplShadowMapsGpu::device_bytes(resolution, 30)), 256);
    gpu::Buffer device_vpls = gpu::make_buffer(device, "test vpls", std::span<const gpu::Vpl>(vpls));
    const std::vector<uint32_t> words = {77, static_cast<uint32_t>(vpls.size())};
    gpu::Buffer count = gpu::make_buffer(device, "test count", std::span<const uint32_t>(words));
    gpu::CommandList commands(device);
    counters.record_clear(commands);
    commands.fill(maps.reach(), 0);
    maps.record(commands, device_vpls, {count, 1});
    counters.record_readback(commands);
    commands.submit();
    commands.wait();
    Counts counts;
    counters.read(counts);
    EXPECT_EQ(counts.shadow_rays, host.reach_m().size());

    const std::vector<float> reach_m =
        gpu::read_back<float>(device, maps.reach(), maps.reach().bytes() / sizeof(float));
    size_t apart = 0, met = 0;
    for (size_t i = 0; i < reach_m.size(); ++i) {
        if (i >= host.reach_m().size()) {
            ASSERT_EQ(reach_m[i], 0) << "a map of no light";
            continue;
        }
        const float expected = host.reach_m()[i];
        met += std::isfinite(expected);
        apart += !(reach_m[i] == expected || std::fabs(reach_m[i] - expected) < 1e-4f * expected);
    }
    EXPECT_GT(2 * met, host.reach_m().size()) << "most rays meet something";
    // A texel's ray that passes an edge within rounding meets either side of it.
    EXPECT_LE(apart, host.reach_m().size() / 1000);

    // The answers, of the same maps.
    std::vector<Question> questions;
    for (const gpu::Vpl& point : test::vpls_on(scene, *intersector, 200, 2))
        for (uint32_t light = 0; light < vpls.size(); ++light) questions.push_back({light, resolution, point.position});
    const auto answers =
        test::run_twin<uint32_t>("tests/gpu/vpl_map_occluded.comp", questions.size(),
                                 {{"vpl_map_reach_m", host.reach_m()}, {"vpls", vpls}, {"questions", questions}});
    size_t different = 0, occluded = 0;
    for (size_t i = 0; i < questions.size(); ++i) {
        different += host.occluded(questions[i].light, questions[i].point) != (answers[i] != 0);
        occluded += answers[i];
    }
    EXPECT_GT(occluded, questions.size() / 20);
    EXPECT_LT(occluded, questions.size() * 19 / 20);
    EXPECT_LE(different, questions.size() / 1000);
}
INSTANTIATE_TEST_SUITE_P(Scenes, GpuVplShadowMaps,
                         testing::Values(std::pair("cornell-box", 4u), std::pair("cornell-box", 33u),
                                         std::pair("cornell-box", 128u), std::pair("interior", 16u)),
                         [](const auto& of) { return "Maps" + std::to_string(of.index); });

}  // namespace
}  // namespace photond::gpu_vpl_shadow_maps_test
