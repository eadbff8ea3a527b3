// Voxel cone tracing: lights are in their voxels, larger cells have their mean, and cones see what a surface sends.

#include <gtest/gtest.h>

#include "renderer/backends/gpu/counters.h"
#include "renderer/methods/voxel_cone_tracing/cone_tree_gpu.h"
#include "renderer/methods/voxel_cone_tracing/voxel_cone_tracing_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/open_scene.h"
#include "tests/support/path_render.h"

namespace photond::gpu_voxel_cone_tracing_test {
namespace {

using Vct = VoxelConeTracingGpu;
using Settings = test::RenderSettingsOf<Vct>;

constexpr double kStandardErrors = 5.2;  // false alarms 2e-7

Settings small_settings(uint32_t passes) {
    Settings settings;
    settings.size = {32, 24};
    settings.passes = passes;
    settings.seed = 5;
    settings.params.vpls = 8192;
    settings.params.map_resolution = 128;
    settings.params.voxel_resolution = 64;
    settings.params.sampler = SamplerKind::Random;
    return settings;
}

vec3 unpacked(uint32_t bits) {
    if (bits == 0) return vec3(0);
    return vec3(bits & 0xffu, bits >> 8 & 0xffu, bits >> 16 & 0xffu) * std::exp2(float(int(bits >> 24) - 136));
}

/// A tree that one pass of lights has lit.
struct LitTree {
    explicit LitTree(const Scene& scene, uint32_t resolution) {
        const test::SceneOnDevice where(scene);
        const EmissionSampler emission(scene);
        gpu::Device& device = test::gpu_device();
        gpu::Counters counters(device);
        VplTracerGpu tracer(where.device_scene, emission, {.vpls = 20000, .map_side = 128}, counters.buffer(), false);
        Stats stats;
        const VoxelGrid grid = make_voxel_grid(scene.bounds, resolution);
        ConeTreeGpu tree(where.device_scene, grid, tracer.most_lights(), stats);
        gpu::CommandList commands(device);
        counters.record_clear(commands);
        tracer.start(1, 0);
        tracer.record_map(commands);
        tracer.record_vpls(commands);
        tree.record(commands, tracer);
        commands.submit();
        commands.wait();
        layout = tree.layout();
        cells = gpu::read_back<gpu::ConeCell>(device, tree.cells(), tree.cells().bytes() / sizeof(gpu::ConeCell));
        const auto photons = gpu::read_back<ReflectedPhoton>(device, tracer.photons(), tracer.most_lights());
        const uint32_t count =
            gpu::read_back<uint32_t>(device, tracer.state(), REFLECTION_STATE_WORDS)[REFLECTION_PHOTONS];
        const double per_m2 = 1 / (double{grid.cell_m} * double{grid.cell_m});
        for (const uint32_t i : gpu::read_back<uint32_t>(device, tracer.order(), count)) {
            const ReflectedPhoton& photon = photons[i];
            for (int axis = 0; axis < 3; ++axis)
                sent[2 * axis + (photon.normal[axis] < 0 ? 1 : 0)] += std::numbers::inv_pi * per_m2 *
                                                                      double(std::fabs(photon.normal[axis])) *
                                                                      double{luminance(photon.power_w)};
        }
    }

    /// Sum of the sides of cells [first, end).
    std::array<double, 6> sums(uint32_t first, uint32_t end) const {
        std::array<double, 6> sums{};
        for (uint32_t i = first; i < end; ++i)
            for (size_t side = 0; side < 6; ++side) sums[side] += double{luminance(unpacked(cells[i].light[side]))};
        return sums;
    }

    gpu::ConeTreeConstants layout;
    std::vector<gpu::ConeCell> cells;
    std::array<double, 6> sent{};  // by the lights, from the six sides
};

/// Light is kept to 1/512 of a voxel's brightest channel.
TEST(ConeTree, HasAllLightInItsVoxels) {
    for (const char* name : {"cornell-box", "cornell-box-glossy"}) {
        const LitTree tree(make_builtin_scene(name), 64);
        const std::array<double, 6> voxels = tree.sums(0, tree.layout.voxels);
        for (size_t side = 0; side < 6; ++side) {
            std::printf("%s, side %zu: %.4f of it\n", name, side, voxels[side] / std::max(tree.sent[side], 1e-30));
            EXPECT_NEAR(voxels[side], tree.sent[side], 0.01 * tree.sent[side]) << name;
        }
    }
}

/// Nothing of a floor and a wall lies behind another part of the same, seen along an axis.
TEST(ConeTree, LargerCellsHaveTheMeanOfTheirParts) {
    const LitTree tree(test::floor_and_wall("point"), 64);
    const gpu::ConeTreeConstants& at = tree.layout;
    const auto voxels = tree.sums(0, at.voxels), halves = tree.sums(at.first_half, at.first_brick),
               bricks = tree.sums(at.first_brick, at.first_node);
    for (size_t side = 0; side < 6; ++side) {
        EXPECT_NEAR(4 * halves[side], voxels[side], 0.005 * voxels[side]) << side;
        EXPECT_NEAR(16 * bricks[side], voxels[side], 0.005 * voxels[side]) << side;
    }
    EXPECT_GT(voxels[2], 0) << "the floor from above";
    EXPECT_GT(voxels[4], 0) << "the wall from before it";
    EXPECT_EQ(voxels[3], 0) << "the floor from below";
}

TEST(GpuVoxelConeTracing, OneCellByChanceHasTheMeanOfAll) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    Settings settings = small_settings(26);
    settings.params.bounces = 1;
    const auto means = [&](ConeCells cells) {
        settings.params.cells = cells;
        std::vector<double> of_passes;
        test::run_passes(where, settings, [&](Vct& method, uint32_t pass) {
            Film film(settings.size, settings.layers, pass);
            method.resolve(film);
            of_passes.push_back(test::mean_of_layer(film, Layer::Indirect));
        });
        return of_passes;
    };
    // Passes have the same lights and cones, whose noise is not in the difference.
    const std::vector<double> chance = means(ConeCells::Chance), all = means(ConeCells::All);
    test::RunningMean difference, wanted;
    for (size_t pass = 0; pass < all.size(); ++pass) difference.add(chance[pass] - all[pass]), wanted.add(all[pass]);
    const double doubt = kStandardErrors * difference.standard_error();
    std::printf("%.5f, apart %.5f, %.2f %% in doubt\n", wanted.mean(), difference.mean(), 100 * doubt / wanted.mean());
    EXPECT_LT(std::fabs(difference.mean()), doubt);
    EXPECT_LT(doubt, 0.02 * wanted.mean()) << "too noisy to notice a defect";
}

/// Path tracing is the answer; what is asked is no more than that nothing is off by a factor.
TEST(GpuVoxelConeTracing, ScenesAreAboutAsBrightAsTheyAre) {
    for (const char* name : {"cornell-box", "floor and wall"}) {
        const Scene scene =
            std::string(name) == "cornell-box" ? make_builtin_scene(name) : test::floor_and_wall("spot");
        test::RenderSettings traced;
        traced.size = {32, 24};
        traced.passes = 200;
        const double wanted = test::indirect_of_passes(scene, traced).mean();
        const double found = test::indirect_of_passes(test::SceneOnDevice(scene), small_settings(8)).mean();
        std::printf("%s: %.3f of path tracing\n", name, found / wanted);
        EXPECT_NEAR(found, wanted, 0.25 * wanted) << name;
    }
}

TEST(GpuVoxelConeTracing, SameBitsTwiceAndNothingThatIsNoNumber) {
    for (const char* name : {"cornell-box-glossy", "cornell-box-spot"}) {
        const Scene scene = make_builtin_scene(name);
        const test::SceneOnDevice where(scene);
        Settings settings = small_settings(2);
        settings.layers.add(Layer::ConeMip);
        const Film film = test::render(where, settings);
        EXPECT_EQ(film.pixel_hash(), test::render(where, settings).pixel_hash()) << name;
        EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
        EXPECT_GT(test::mean_of_layer(film, Layer::Indirect), 0);
        EXPECT_GT(test::mean_of_layer(film, Layer::ConeMip), 0);
    }
}

TEST(GpuVoxelConeTracing, DarkScenesAndNoBouncesAreBlack) {
    const Scene dark = test::floor_and_wall("none");
    const Scene lit = test::floor_and_wall("environment");
    for (const Scene* scene : {&dark, &lit}) {
        const test::SceneOnDevice where(*scene);
        Settings settings = small_settings(1);
        EXPECT_EQ(test::indirect_of_passes(where, settings).mean() > 0, scene == &lit);
        settings.params.bounces = 0;
        EXPECT_EQ(test::indirect_of_passes(where, settings).mean(), 0);
    }
}

TEST(GpuVoxelConeTracing, TakesTheDeviceMemoryItSays) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    Settings settings = small_settings(1);
    settings.size = {160, 120};
    settings.params.voxel_resolution = 128;
    test::expect_device_bytes_as_estimated(where, settings);
}

}  // namespace
}  // namespace photond::gpu_voxel_cone_tracing_test
