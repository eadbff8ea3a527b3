// Depth maps of beams: those that are drawn against those that are traced, texel by texel.

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/backends/gpu/counters.h"
#include "renderer/core/rng.h"
#include "renderer/methods/photon_splatting/splat_depth_atlas.h"
#include "renderer/methods/photon_splatting/splat_shared.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/scene.h"
#include "tests/support/gpu_twin.h"

namespace photond::gpu_splat_depth_test {
namespace {

constexpr const char* kTraced = "renderer/methods/photon_splatting/splat_depth.comp";

gpu::SplatConstants constants_of(uint32_t resolution) {
    gpu::SplatConstants constants{};
    constants.shadow_resolution = resolution;
    return constants;
}

/// Frusta anywhere in the scene's bounds, in any direction; each seventh splat is none.
std::vector<gpu::Splat> splats_in(const Scene& scene, size_t count) {
    RandomStream random(count, RandomDomain::Test, 0, 0);
    std::vector<gpu::Splat> splats(count);
    for (size_t i = 0; i < count; ++i) {
        const vec3 u(random.next(), random.next(), random.next());
        gpu::Splat& splat = splats[i];
        splat.origin = scene.bounds.min + scene.bounds.diagonal() * u;
        splat.axis = glm::normalize(vec3(random.next(), random.next(), random.next()) - 0.49f);
        splat.radius = scene.bounds.radius() * (0.02f + 0.2f * random.next());
        splat.near_m = scene.bounds.radius() * 0.5f * random.next();
        splat.far_m = splat.near_m + scene.bounds.radius() * random.next();
        splat.kind = i % 7 == 6 ? SPLAT_NONE : SPLAT_BEAM;
    }
    return splats;
}

/// Both forms' maps of a scene's splats, and what no splat writes.
class Maps {
public:
    Maps(const Scene& scene, uint32_t resolution, size_t splats)
        : device_(test::gpu_device()),
          scene_(device_, scene),
          resolution_(resolution),
          host_splats(splats_in(scene, splats)),
          constants_(device_, "test constants", sizeof(gpu::SplatConstants)),
          splats_(gpu::make_buffer(device_, "test splats", std::span<const gpu::Splat>(host_splats))),
          maps_(device_, "test maps", splats * resolution * resolution * sizeof(float)),
          counters_(device_) {
        const gpu::SplatConstants constants = constants_of(resolution);
        gpu::upload(device_, constants_, std::as_bytes(std::span(&constants, 1)));
    }

    std::vector<float> traced() {
        const gpu::ComputePipeline trace(device_, kTraced, sizeof(gpu::SplatClusterPush), &scene_.set(),
                                         scene_.specialization({}));
        gpu::CommandList commands(device_);
        counters_.record_clear(commands);
        commands.fill(maps_, 0);
        commands.bind(trace,
                      {gpu::read_write("device_counters", counters_.buffer()), gpu::read("constants", constants_),
                       gpu::read("splats", splats_), gpu::write("farthest_m", maps_)});
        commands.push(gpu::SplatClusterPush{0, 0, 0, count()});
        commands.dispatch_threads(uint64_t{count()} * SPLAT_GROUP, SPLAT_GROUP);
        return read(commands);
    }
    std::vector<float> drawn() {
        SplatDepthAtlas atlas(scene_, resolution_, count());
        gpu::CommandList commands(device_);
        commands.fill(maps_, 0);
        for (uint32_t first = 0; first < count(); first += atlas.splats_at_once())
            atlas.record(commands, constants_, splats_, maps_, first,
                         std::min(first + atlas.splats_at_once(), count()));
        return read(commands);
    }

    uint32_t count() const { return static_cast<uint32_t>(host_splats.size()); }

private:
    std::vector<float> read(gpu::CommandList& commands) {
        commands.submit();
        commands.wait();
        return gpu::read_back<float>(device_, maps_, maps_.bytes() / sizeof(float));
    }

    gpu::Device& device_;
    const gpu::DeviceScene scene_;
    const uint32_t resolution_;

public:
    const std::vector<gpu::Splat> host_splats;

private:
    gpu::Buffer constants_, splats_, maps_;
    gpu::Counters counters_;
};

struct MapCase {
    const char* scene;
    uint32_t resolution, splats;
};
class GpuSplatDepth : public testing::TestWithParam<MapCase> {};

// A texel whose centre an edge passes within rounding is on either side of it, and its 3x3 with it.
TEST_P(GpuSplatDepth, DrawnMapsAreTheTracedOnesButForSilhouettes) {
    const MapCase& of = GetParam();
    const Scene scene = make_builtin_scene(of.scene);
    ASSERT_TRUE(SplatDepthAtlas::possible(scene));
    Maps maps(scene, of.resolution, of.splats);
    const std::vector<float> traced = maps.traced(), drawn = maps.drawn();
    const size_t texels = size_t{of.resolution} * of.resolution;
    size_t apart = 0, within = 0, beams = 0;
    for (size_t i = 0; i < traced.size(); ++i) {
        const gpu::Splat& splat = maps.host_splats[i / texels];
        if (splat.kind != SPLAT_BEAM) {
            ASSERT_EQ(drawn[i], 0) << "a map of no splat";
            continue;
        }
        ++beams;
        const float depth_m = splat.far_m - splat.near_m, texel_m = 2 * splat.radius / float(of.resolution);
        within += traced[i] < 0.999f * (depth_m + texel_m) ? 1 : 0;
        apart += std::fabs(drawn[i] - traced[i]) > 1e-4f * scene.bounds.radius() ? 1 : 0;
    }
    EXPECT_GT(double(within), 0.1 * double(beams)) << "something is met";
    EXPECT_LE(double(apart), 0.002 * double(beams));
}
INSTANTIATE_TEST_SUITE_P(Scenes, GpuSplatDepth,
                         testing::Values(MapCase{"cornell-box", 16, 300}, MapCase{"cornell-box", 4, 100},
                                         MapCase{"cornell-box", 63, 30}, MapCase{"interior", 16, 60}));

TEST(GpuSplatDepth, IsChosenWhereTrianglesAreFewerThanRays) {
    const auto faster = [](const char* name, uint32_t resolution) {
        const Scene scene = make_builtin_scene(name);
        return SplatDepthAtlas::faster(scene.needs, scene.triangle_count, resolution);
    };
    EXPECT_TRUE(faster("cornell-box", 64));
    EXPECT_FALSE(faster("cornell-box", 4));
    EXPECT_FALSE(faster("interior", 16));
    Needs alpha;
    alpha.alpha = true;
    EXPECT_FALSE(SplatDepthAtlas::faster(alpha, 32, 64));
    EXPECT_FALSE(SplatDepthAtlas::possible(Scene{}));
}

}  // namespace
}  // namespace photond::gpu_splat_depth_test
