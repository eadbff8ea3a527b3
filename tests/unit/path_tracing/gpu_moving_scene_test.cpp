// Moving scenes on a GPU: what follows a pose there is what is uploaded anew, and the CPU's picture.

#include <gtest/gtest.h>

#include "renderer/methods/path_tracing/path_tracing_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/pose.h"
#include "tests/support/gpu_render.h"

namespace photond::gpu_moving_scene_test {
namespace {

template <class M>
test::RenderSettingsOf<M> settings_of(uint32_t passes) {
    test::RenderSettingsOf<M> settings;
    settings.size = {32, 24};
    settings.passes = passes;
    return settings;
}

Film render(const Scene& scene, const gpu::DeviceScene& device_scene, uint32_t passes) {
    const auto settings = settings_of<PathTracingGpu>(passes);
    const gpu::DeviceIntersector intersector(device_scene);
    MemoryBudget budget;
    Stats stats;
    const RenderContext context{scene, &intersector, test::view_of(scene, settings), 1, budget, &device_scene};
    Film film(settings.size, settings.layers);
    test::run_passes_in(
        context, settings, [&](PathTracingGpu& method, uint32_t) { method.resolve(film); }, stats);
    return film;
}

class MovingSceneOnDevice : public testing::TestWithParam<const char*> {};

TEST_P(MovingSceneOnDevice, FollowsAPoseToTheBitsOfOneThatIsUploadedAnew) {
    Scene scene = make_builtin_scene(GetParam());
    Stats stats;
    gpu::DeviceScene kept(test::gpu_device(), scene, stats);
    for (const double time : {0.2, 0.7, 0.2}) {
        kept.follow(pose_scene(scene, {0, time}), stats);
        const gpu::DeviceScene fresh(test::gpu_device(), scene, stats);
        EXPECT_EQ(render(scene, kept, 2).pixel_hash(), render(scene, fresh, 2).pixel_hash()) << "at " << time;
    }
}
INSTANTIATE_TEST_SUITE_P(Scenes, MovingSceneOnDevice,
                         testing::Values("moving/cornell-box", "moving/appearing", "moving/light-switched-on"),
                         [](const auto& info) { return "Scene" + std::to_string(info.index); });

// The same numbers make the same paths there, but for rounding.
TEST(MovingSceneOnDevice, ShowsTheFrameOfTheCpuWithinThreePerMille) {
    Scene scene = make_builtin_scene("moving/cornell-box");
    Stats stats;
    gpu::DeviceScene device_scene(test::gpu_device(), scene, stats);
    for (const double time : {0.6, 2.3}) {
        device_scene.follow(pose_scene(scene, {0, time}), stats);
        const double cpu = test::mean_of(test::render(scene, settings_of<PathTracing>(8)).resolve_beauty());
        EXPECT_NEAR(test::mean_of(render(scene, device_scene, 8).resolve_beauty()) / cpu, 1, 0.003) << "at " << time;
    }
}

}  // namespace
}  // namespace photond::gpu_moving_scene_test
