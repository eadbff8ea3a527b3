// The voxel octree of a moving scene's next frame at 256^3, on the device: 200,000 triangles of which a tenth moves.
// Each frame's tree is made in three ways, one after the other, so that all have the same share of the machine: by what
// the frame before left; anew in the room that a tree has, which is the device's work alone; and anew as by a method
// that was left nothing. Medians, and what keeping is worth.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <map>

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/voxels/kept_voxels.h"
#include "renderer/voxels/kept_voxels_gpu.h"
#include "tests/benchmarks/crowd.h"
#include "tests/support/gpu_twin.h"

namespace photond {
namespace {

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

struct Way {
    std::vector<double> wall_ms;
    std::map<std::string, std::vector<double>> stage_ms;

    template <class Make>
    void time(const Make& make) {
        Stats stats;
        const double start = wall_now_seconds();
        make(stats);
        wall_ms.push_back(1e3 * (wall_now_seconds() - start));
        for (const Stage& stage : stats.stages) stage_ms[stage.name].push_back(1e3 * stage.gpu_seconds);
    }
};

void octree(benchmark::State& state) {
    Scene scene = test::make_crowd();
    const VoxelGrid grid = make_voxel_grid(scene.bounds, 256);
    gpu::DeviceScene device_scene(test::gpu_device(), scene);
    KeptVoxels kept;
    double time = 0;
    const auto pose = [&] {
        time = time < 1 ? time + 1.0 / 64 : 0;
        const SceneChange change = pose_scene(scene, {0, time});
        kept.note(change);
        Stats stats;
        device_scene.follow(change, stats);
    };
    FrameOctreeGpu followed;
    const auto follow = [&](Stats& stats) {
        followed = {&kept, device_scene, grid, true, stats};
        followed.settle(stats);
    };
    SparseVoxelOctreeGpu roomy(device_scene, grid, true);
    Stats before;
    roomy.build_now(before);
    constexpr int kFramesUntilItFollows = 3;
    for (int i = 0; i < kFramesUntilItFollows; ++i) pose(), follow(before);
    std::map<std::string, Way> ways;
    for ([[maybe_unused]] auto _ : state) {
        state.PauseTiming();
        pose();
        ways["anew"].time(
            [&](Stats& stats) { FrameOctreeGpu(nullptr, device_scene, grid, true, stats).settle(stats); });
        ways["in_its_room"].time([&](Stats& stats) { roomy.start_rebuild(), roomy.settle(stats); });
        state.ResumeTiming();
        ways["followed"].time(follow);
    }
    for (const auto& [name, way] : ways) {
        state.counters[name + "_ms"] = median(way.wall_ms);
        for (const auto& [stage, ms] : way.stage_ms) state.counters[name + "_" + stage + "_ms"] = median(ms);
    }
    const double follows_ms = median(ways["followed"].wall_ms);
    state.counters["anew_over_followed"] = median(ways["anew"].wall_ms) / follows_ms;
    state.counters["in_its_room_over_followed"] = median(ways["in_its_room"].wall_ms) / follows_ms;
    state.counters["voxels"] = static_cast<double>(followed->voxel_count());
    state.counters["fragments"] = static_cast<double>(roomy.fragment_count());
    state.counters["moving_fragments"] = static_cast<double>(followed->fragment_count());
    state.counters["tree_MB"] = 1e-6 * static_cast<double>(followed->device_bytes());
    state.counters["kept_MB"] = 1e-6 * static_cast<double>(followed->device_bytes_with_scratch());
}
BENCHMARK(octree)->UseRealTime()->Iterations(20)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace photond

BENCHMARK_MAIN();
