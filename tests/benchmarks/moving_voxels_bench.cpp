// The voxel octree of a moving scene's next frame at 256^3, on the processor's cores: 200,000 triangles of which a
// tenth moves. Built anew over followed, what keeping is worth.

#include <benchmark/benchmark.h>

#include "renderer/voxels/kept_voxels.h"
#include "tests/benchmarks/crowd.h"

namespace photond {
namespace {

/// `state.range(0)`: what the frame before left is there.
void octree(benchmark::State& state) {
    Scene scene = test::make_crowd();
    const VoxelGrid grid = make_voxel_grid(scene.bounds, 256);
    KeptVoxels kept;
    MemoryBudget budget;
    Stats stats;
    double time = 0;
    const auto pose = [&] {
        time = time < 1 ? time + 1.0 / 64 : 0;
        kept.note(pose_scene(scene, {0, time}));
        if (!state.range(0)) kept.clear();
    };
    pose();
    (void)kept.octree(scene, grid, true, budget, stats);
    for ([[maybe_unused]] auto _ : state) {
        state.PauseTiming();
        pose();
        state.ResumeTiming();
        const SparseVoxelOctree tree = kept.octree(scene, grid, true, budget, stats);
        state.counters["voxels"] = static_cast<double>(tree.voxel_count());
        state.counters["kept_MB"] = 1e-6 * static_cast<double>(kept.bytes());
        state.counters["tree_MB"] = 1e-6 * static_cast<double>(tree.bytes());
    }
}
BENCHMARK(octree)->ArgName("kept")->Arg(0)->Arg(1)->Arg(0)->Arg(1)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace photond

BENCHMARK_MAIN();
