// Voxels on the device against the CPU's: the same trees bit for bit, and the same answers but for rays that rounding
// sends past a corner on either side.

#include <gtest/gtest.h>

#include <cstring>

#include "renderer/scene/builtin_scenes.h"
#include "renderer/voxels/sparse_voxel_octree.h"
#include "renderer/voxels/sparse_voxel_octree_gpu.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/voxels.h"

namespace photond::gpu_voxels_test {
namespace {

Scene scene_named(const std::string& name) {
    return name == "medley" ? test::voxel_medley() : make_builtin_scene(name);
}

/// A device's tree, on the host.
struct ReadBack {
    ReadBack(SparseVoxelOctreeGpu& tree, bool with_surfaces)
        : constants(tree.host_constants()),
          nodes(gpu::read_back<gpu::SvoNode>(test::gpu_device(), tree.nodes(), tree.node_count())),
          bricks(gpu::read_back<gpu::SvoBrick>(test::gpu_device(), tree.bricks(), tree.brick_count())),
          surfaces(gpu::read_back<uint32_t>(test::gpu_device(), tree.surfaces(),
                                            with_surfaces ? tree.surfaces().bytes() / 4 : 0)) {}
    SvoView view() const { return {constants, nodes, bricks, surfaces}; }

    gpu::SvoConstants constants;
    std::vector<gpu::SvoNode> nodes;
    std::vector<gpu::SvoBrick> bricks;
    std::vector<uint32_t> surfaces;
};

template <class T>
bool same(std::span<const T> a, std::span<const T> b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

void expect_the_cpus(const Scene& scene, uint32_t resolution, bool surfaces = true) {
    const gpu::DeviceScene device_scene(test::gpu_device(), scene);
    const VoxelGrid grid = make_voxel_grid(scene.bounds, resolution);
    const SparseVoxelOctree expected(scene, grid, surfaces);
    SparseVoxelOctreeGpu tree(device_scene, grid, surfaces);
    Stats stats;
    tree.build_now(stats);
    EXPECT_EQ(tree.voxel_count(), expected.voxel_count());
    const ReadBack real(tree, surfaces);
    const SvoView view = real.view(), cpu = expected.view();
    if (expected.voxel_count() > 0) {
        EXPECT_TRUE(std::memcmp(&view.constants, &cpu.constants, sizeof cpu.constants) == 0);
    }
    EXPECT_TRUE(same(view.nodes, cpu.nodes));
    EXPECT_TRUE(same(view.bricks, cpu.bricks));
    if (expected.voxel_count() > 0) {
        EXPECT_TRUE(same(view.surfaces, cpu.surfaces));
    }
    EXPECT_EQ(test::list_voxels(view), test::list_voxels(cpu));
    EXPECT_GT(stats.stage("voxelise").gpu_seconds, 0);
    EXPECT_GT(stats.stage("svo_build").gpu_seconds, 0);
}

class GpuVoxels : public testing::TestWithParam<const char*> {};

TEST_P(GpuVoxels, AreTheCpus) {
    const Scene scene = scene_named(GetParam());
    for (const uint32_t resolution : {16u, 64u, 128u, 256u}) expect_the_cpus(scene, resolution);
    expect_the_cpus(scene, 32, false);
}
INSTANTIATE_TEST_SUITE_P(Scenes, GpuVoxels,
                         testing::Values("medley", "cornell-box", "photon-splatting/chairs", "interior"));

TEST(GpuVoxels, AreTheCpusAt1024) { expect_the_cpus(test::voxel_medley(), 1024); }

class GpuVoxelsShortOfRoom : public testing::TestWithParam<bool> {};

/// Hairs have hardly any area to expect voxels by: the first build is short of room.
TEST_P(GpuVoxelsShortOfRoom, Grow) {
    Scene scene;
    MeshBuilder builder;
    RandomStream random(5, RandomDomain::Test, 0, 0);
    for (int i = 0; i < 300; ++i) {
        const vec3 a = test::random_vec3(random), b = test::random_vec3(random);
        builder.triangle(a, b, b + vec3(0, 1e-5f, 0));
    }
    test::add(scene, builder.build(0), test::lambert(0.5f));
    finish_scene(scene);
    const gpu::DeviceScene device_scene(test::gpu_device(), scene);
    SparseVoxelOctreeGpu tree(device_scene, make_voxel_grid(scene.bounds, 256), GetParam());
    for (int builds = 1;; ++builds) {
        gpu::CommandList commands(test::gpu_device());
        tree.record_build(commands);
        commands.submit();
        commands.wait();
        const auto root = gpu::read_back<gpu::SvoNode>(test::gpu_device(), tree.nodes(), 8);
        const bool is_empty = std::ranges::none_of(root, [](const gpu::SvoNode& n) { return n.info & SVO_FLAGGED; });
        const bool was_short = tree.grow_if_short();
        EXPECT_EQ(is_empty, was_short) << "nobody walks down to what there was no room for";
        if (!was_short) {
            EXPECT_GT(builds, 1);
            break;
        }
        ASSERT_LT(builds, 10);
    }
    // Again within the room there is now: the same.
    const uint64_t voxels = tree.voxel_count(), room = tree.device_bytes();
    const auto list = test::list_voxels(ReadBack(tree, GetParam()).view());
    EXPECT_EQ(list, test::list_voxels(SparseVoxelOctree(scene, tree.host_constants().grid, GetParam()).view()));
    EXPECT_EQ(list.voxels.size(), voxels);
    Stats stats;
    tree.build_now(stats);
    EXPECT_EQ(tree.voxel_count(), voxels);
    EXPECT_LT(tree.device_bytes(), room);  // what was too much is given back
    EXPECT_EQ(test::list_voxels(ReadBack(tree, GetParam()).view()), list);
}
INSTANTIATE_TEST_SUITE_P(Surfaces, GpuVoxelsShortOfRoom, testing::Bool());

TEST(GpuVoxels, TakeTheBytesTheySay) {
    const Scene scene = make_builtin_scene("interior");
    const gpu::DeviceScene device_scene(test::gpu_device(), scene);
    const VoxelGrid grid = make_voxel_grid(scene.bounds, 256);
    for (const bool surfaces : {false, true}) {
        SparseVoxelOctreeGpu tree(device_scene, grid, surfaces);
        const double before = double(tree.device_bytes_with_scratch());
        EXPECT_LT(before, 1.01 * double(SparseVoxelOctreeGpu::estimate_device_bytes(scene, grid, surfaces)) + 4096);
        Stats stats;
        tree.build_now(stats);
        const SparseVoxelOctree cpu(scene, grid, surfaces);
        EXPECT_EQ(tree.voxel_count(), cpu.voxel_count());
        EXPECT_NEAR(double(tree.device_bytes()), double(cpu.bytes() - cpu.view().cells->bytes()), 256);
        EXPECT_LT(tree.bytes_a_voxel(), surfaces ? 8 : 4);
        EXPECT_GT(tree.bytes_a_voxel(), surfaces ? 4 : 0.125);
    }
}

TEST(GpuVoxels, OfAnEmptySceneAreNone) {
    Scene scene;
    finish_scene(scene);
    expect_the_cpus(scene, 128);
}

}  // namespace
}  // namespace photond::gpu_voxels_test
