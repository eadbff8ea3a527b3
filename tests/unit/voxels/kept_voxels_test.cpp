// Octrees that follow from those of earlier frames against octrees that are built anew: the same bits, whatever moved.

#include "renderer/voxels/kept_voxels.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/support/theatre.h"

namespace photond::kept_voxels_test {
namespace {

template <class T>
void expect_same(std::span<const T> a, std::span<const T> b, const char* what) {
    EXPECT_EQ(a.size(), b.size()) << what;
    EXPECT_TRUE(a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0) << what;
}

void expect_same_bits(const SparseVoxelOctree& tree, const SparseVoxelOctree& anew) {
    expect_same(std::span(&tree.constants(), 1), std::span(&anew.constants(), 1), "constants");
    const SvoView a = tree.view(), b = anew.view();
    expect_same<gpu::SvoNode>(a.nodes, b.nodes, "nodes");
    expect_same<gpu::SvoBrick>(a.bricks, b.bricks, "bricks");
    expect_same<uint32_t>(a.surfaces, b.surfaces, "surfaces");
    expect_same(tree.first_triangles(), anew.first_triangles(), "first triangles");
    EXPECT_EQ(a.cells->starts, b.cells->starts);
    EXPECT_EQ(a.cells->free, b.cells->free);
    EXPECT_EQ(tree.voxel_count(), anew.voxel_count());
}

/// A scene and what is kept of it.
struct Theatre {
    Scene scene = test::make_theatre();
    KeptVoxels kept;
    MemoryBudget budget;

    /// How often the tree followed from the one before.
    int show(double time, const std::optional<VoxelGrid>& fixed, uint32_t resolution, bool surfaces) {
        kept.note(pose_scene(scene, {0, time}));
        return follow(fixed ? *fixed : make_voxel_grid(scene.bounds, resolution), surfaces);
    }
    int follow(const VoxelGrid& grid, bool surfaces) {
        Stats stats;
        expect_same_bits(kept.octree(scene, grid, surfaces, budget, stats), SparseVoxelOctree(scene, grid, surfaces));
        return stats.stages.front().name == "svo_update";
    }
};

// Moments in no order, so that all that moves also teleports.
TEST(KeptVoxels, MakeTheTreeThatIsBuiltAnew) {
    for (const bool surfaces : {false, true}) {
        Theatre theatre;
        const VoxelGrid grid = make_voxel_grid({vec3(-2), vec3(2)}, 64);  // which one of the spheres leaves
        int updates = 0;
        for (const double time : {0.0, 0.1, 0.5, 0.45, 1.0, 0.75, 0.5, 0.2})
            updates += theatre.show(time, grid, 64, surfaces);
        EXPECT_EQ(updates, 7) << "all but the first";
    }
}

TEST(KeptVoxels, AreMadeAnewWhereTheGridOrWhatIsAskedForIsAnother) {
    Theatre theatre;
    EXPECT_EQ(theatre.show(0, {}, 32, true), 0);
    EXPECT_EQ(theatre.show(0.1, {}, 32, true), 1);
    EXPECT_EQ(theatre.show(0.1, {}, 32, false), 0);
    EXPECT_EQ(theatre.show(0.1, {}, 64, false), 0);
    EXPECT_EQ(theatre.show(0.9, {}, 64, false), 0) << "the sphere that left has moved the scene's bounds";
    EXPECT_EQ(theatre.show(0.1, {}, 64, false), 0);
}

// Two poses are shown to one who asks once, and one to one who asks twice.
TEST(KeptVoxels, HearOfAllThatMovedSinceTheyWereAsked) {
    Theatre theatre;
    const VoxelGrid grid = make_voxel_grid(theatre.scene.bounds, 32);
    EXPECT_EQ(theatre.show(0.2, grid, 32, true), 0);
    theatre.kept.note(pose_scene(theatre.scene, {0, 0.6}));
    EXPECT_EQ(theatre.show(0.3, grid, 32, true), 1);
    EXPECT_EQ(theatre.follow(grid, true), 1);
    theatre.kept.note(pose_scene(theatre.scene, {}));
    EXPECT_EQ(theatre.follow(grid, true), 1);
}

TEST(KeptVoxels, AreNoneOfWhatIsStillAndWhereMemoryIsShort) {
    Theatre theatre;
    const VoxelGrid grid = make_voxel_grid(theatre.scene.bounds, 32);
    Stats stats;
    const SparseVoxelOctree tree = make_octree(&theatre.kept, theatre.scene, grid, true, theatre.budget, stats);
    const uint64_t kept = theatre.kept.bytes();
    EXPECT_GT(kept, 0u);
    EXPECT_EQ(theatre.budget.structures().at("kept_voxels"), kept);
    EXPECT_EQ(theatre.budget.structures().at("sparse_voxel_octree"), tree.bytes());
    theatre.budget = MemoryBudget(tree.bytes() + 8 * kept - 8);
    EXPECT_EQ(theatre.follow(grid, true), 1);
    EXPECT_EQ(theatre.kept.bytes(), 0u) << "more than an eighth of what is left";
    theatre.budget = MemoryBudget();
    theatre.scene.rig = nullptr;
    EXPECT_EQ(theatre.follow(grid, true), 0);
    EXPECT_EQ(theatre.kept.bytes(), 0u);
}

}  // namespace
}  // namespace photond::kept_voxels_test
