// Octrees on the device that follow from those of earlier frames against octrees that are built there anew: the same
// bits, whatever moved.

#include <gtest/gtest.h>

#include <cstring>

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/voxels/kept_voxels.h"
#include "renderer/voxels/kept_voxels_gpu.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/theatre.h"

namespace photond::gpu_kept_voxels_test {
namespace {

const VoxelGrid kGrid = make_voxel_grid({vec3(-2), vec3(2)}, 64);  // which one of the spheres leaves

/// All of a tree.
struct Bits {
    Bits(SparseVoxelOctreeGpu& tree, bool with_surfaces) {
        gpu::Device& device = test::gpu_device();
        const uint64_t words = with_surfaces ? tree.brick_count() + tree.voxel_count() : 0;
        constants = gpu::read_back<gpu::SvoConstants>(device, tree.constants(), 1);
        nodes = gpu::read_back<gpu::SvoNode>(device, tree.nodes(), tree.node_count());
        bricks = gpu::read_back<gpu::SvoBrick>(device, tree.bricks(), tree.brick_count());
        surfaces = gpu::read_back<uint32_t>(device, tree.surfaces(), words);
        voxels = tree.voxel_count();
    }

    std::vector<gpu::SvoConstants> constants;
    std::vector<gpu::SvoNode> nodes;
    std::vector<gpu::SvoBrick> bricks;
    std::vector<uint32_t> surfaces;
    uint64_t voxels;
};

template <class T>
void expect_same(const std::vector<T>& a, const std::vector<T>& b, const char* what, double time) {
    EXPECT_TRUE(a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0)
        << what << " at " << time;
}

/// A scene on the device and what is kept of it.
struct Theatre {
    explicit Theatre(Scene play = test::make_theatre()) : scene(std::move(play)) {}

    Scene scene;
    gpu::DeviceScene device_scene{test::gpu_device(), scene};
    KeptVoxels kept;
    int asked_again = 0;

    void pose(double time) {
        const SceneChange change = pose_scene(scene, {0, time});
        kept.note(change);
        Stats stats;
        device_scene.follow(change, stats);
    }

    /// How the tree came about: A built anew, K from what was kept in this frame, U from what was kept before, - it was
    /// as it is.
    char follow(bool surfaces, const VoxelGrid& grid = kGrid) {
        Stats stats, unused;
        FrameOctreeGpu tree(&kept, device_scene, grid, surfaces, stats);
        if (tree.settle(stats)) ++asked_again;
        SparseVoxelOctreeGpu anew(device_scene, grid, surfaces);
        anew.build_now(unused);
        const double time = scene.moment.time_s;
        const Bits a(*tree.get(), surfaces), b(anew, surfaces);
        expect_same(a.constants, b.constants, "constants", time);
        expect_same(a.nodes, b.nodes, "nodes", time);
        expect_same(a.bricks, b.bricks, "bricks", time);
        expect_same(a.surfaces, b.surfaces, "surfaces", time);
        EXPECT_EQ(a.voxels, b.voxels) << time;
        const auto has = [&](const char* name) { return stats.stage(name).gpu_seconds > 0; };
        if (has("svo_update")) {
            EXPECT_LT(tree->fragment_count(), anew.fragment_count()) << "voxelises what moves alone";
        }
        if (has("svo_update")) return has("svo_build") ? 'K' : 'U';
        return has("svo_build") ? 'A' : '-';
    }

    std::string show(std::initializer_list<double> times, bool surfaces) {
        std::string ways;
        for (const double time : times) pose(time), ways += follow(surfaces);
        return ways;
    }
};

// One flies over the torus and one leaves the grid and comes back, others jump, are let light through, swell, bend,
// and shrink to nothing, after which triangles have other numbers.
TEST(KeptVoxelsGpu, MakeTheTreeThatIsBuiltAnew) {
    for (const bool surfaces : {false, true}) {
        Theatre theatre;
        EXPECT_EQ(theatre.show({0, 0.05, 0.1, 0.15, 0.1, 0.28}, surfaces), "AAKUUU");
        EXPECT_EQ(theatre.show({0.31, 0.35, 0.39}, surfaces), "AKU") << "one has jumped";
        EXPECT_EQ(theatre.show({0.42, 0.44, 0.46}, surfaces), "AKU") << "light passes one";
        EXPECT_EQ(theatre.show({0.1, 0.48, 0.1}, surfaces), "UUU") << "all that has moved once, to and fro";
        EXPECT_EQ(theatre.show({0.5, 0.9, 0.95, 0.98, 1}, surfaces), "AAAKU") << "one has shrunk";
    }
}

TEST(KeptVoxelsGpu, AreAsTheyWereWhereNothingMoved) {
    Theatre theatre;
    EXPECT_EQ(theatre.show({0.1, 0.1, 0.15, 0.15, 0.2, 0.2, 0.25}, true), "A-A-K-U");
}

TEST(KeptVoxelsGpu, AreMadeAnewWhereTheGridOrWhatIsAskedForIsAnother) {
    Theatre theatre;
    EXPECT_EQ(theatre.show({0.1, 0.12, 0.14, 0.16}, true), "AAKU");
    EXPECT_EQ(theatre.follow(false), 'A');
    EXPECT_EQ(theatre.follow(false), '-');
    EXPECT_EQ(theatre.follow(false, make_voxel_grid(theatre.scene.bounds, 32)), 'A');
}

// A sphere that has jumped is voxelised in each frame until that has cost as much as the torus.
TEST(KeptVoxelsGpu, AreOfAllThatCameToRest) {
    Theatre theatre;
    EXPECT_EQ(theatre.show({0.2, 0.29, 0.301, 0.302, 0.303}, false), "AAAKU");
    std::string ways;
    for (int i = 4; i < 19; ++i) ways += theatre.show({0.3 + 0.001 * i}, false);
    EXPECT_EQ(ways, "UUUUUUUUUUUUKUU");
}

// A frame does not wait to hear whether its tree has room. Where it had not, its pass is made again.
TEST(KeptVoxelsGpu, AreAskedAgainWhereTheyOutgrewTheirRoom) {
    for (const bool surfaces : {false, true}) {
        Theatre theatre(test::make_swelling_lamp());
        EXPECT_EQ(theatre.show({0, 0.01, 0.02, 0.03}, surfaces), "AAKU");
        EXPECT_EQ(theatre.asked_again, 0);
        EXPECT_EQ(theatre.show({0.9}, surfaces), "U");
        EXPECT_EQ(theatre.asked_again, 1);
        EXPECT_EQ(theatre.show({0.1, 0.95}, surfaces), "UU");
        EXPECT_EQ(theatre.asked_again, 1) << "there is room now";
    }
}

TEST(KeptVoxelsGpu, FollowFramesThatWereLeftBeforeTheirFirstPass) {
    Theatre theatre(test::make_swelling_lamp());
    EXPECT_EQ(theatre.show({0, 0.01, 0.02, 0.03}, true), "AAKU");
    for (const double time : {0.85, 0.95}) {
        theatre.pose(time);
        Stats stats;
        const FrameOctreeGpu left(&theatre.kept, theatre.device_scene, kGrid, true, stats);
    }
    EXPECT_EQ(theatre.show({0.95, 0.9}, true), "UU") << "whose time is told by who comes next";
    EXPECT_EQ(theatre.asked_again, 0) << "no pass was made of what had no room";
}

TEST(KeptVoxelsGpu, AreNoneOfWhatIsStillAndOfNobody) {
    Theatre theatre;
    EXPECT_EQ(theatre.follow(true), 'A');
    const std::map<std::string, uint64_t> kept = theatre.kept.device_structures(),
                                          held = test::gpu_device().memory().structures();
    EXPECT_GT(kept.at("voxel_tree"), 0u);
    for (const auto& [name, bytes] : kept) EXPECT_LE(bytes, held.at(name)) << name;
    theatre.kept.clear();
    EXPECT_TRUE(theatre.kept.device_structures().empty());
    EXPECT_FALSE(test::gpu_device().memory().structures().contains("voxel_tree"));
    theatre.scene.rig = nullptr;
    EXPECT_EQ(theatre.follow(true), 'A');
    EXPECT_TRUE(theatre.kept.device_structures().empty());
}

}  // namespace
}  // namespace photond::gpu_kept_voxels_test
