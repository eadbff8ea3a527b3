// Frames of a moving scene on a GPU, one after the other: voxels that follow from the frame before make the picture of
// those that are built anew.

#include <gtest/gtest.h>

#include "renderer/methods/svo_many_lights/svo_many_lights_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/pose.h"
#include "renderer/voxels/kept_voxels.h"
#include "tests/support/gpu_render.h"

namespace photond::gpu_moving_voxels_test {
namespace {

std::string picture(const gpu::DeviceScene& scene, KeptVoxels* kept, Stats& stats) {
    test::RenderSettingsOf<SvoManyLightsGpu> settings;
    settings.size = {24, 24};
    settings.passes = 1;
    settings.params.vpls = 64;
    settings.params.visibility = VplVisibility::Svo;
    settings.params.voxel_resolution = 64;
    settings.params.bounces = 2;
    settings.params.bounce_tracing = VplBounces::Voxels;
    const gpu::DeviceIntersector intersector(scene);
    MemoryBudget budget;
    const RenderContext context{.scene = scene.scene(),
                                .intersector = &intersector,
                                .view = test::view_of(scene.scene(), settings),
                                .budget = budget,
                                .device_scene = &scene,
                                .kept_voxels = kept};
    Film film(settings.size, settings.layers);
    test::run_passes_in(
        context, settings, [&](SvoManyLightsGpu& method, uint32_t) { method.resolve(film); }, stats);
    return film.pixel_hash();
}

TEST(MovingVoxelsOnDevice, MakeThePictureOfThoseThatAreBuiltAnew) {
    Scene scene = make_builtin_scene("moving/teleport");
    Stats stats;
    gpu::DeviceScene device_scene(test::gpu_device(), scene, stats);
    KeptVoxels kept;
    std::string follows;
    for (const double time : {0.2, 0.8, 0.49, 0.8}) {
        const SceneChange change = pose_scene(scene, {0, time});
        kept.note(change);
        device_scene.follow(change, stats);
        Stats warm, cold;
        EXPECT_EQ(picture(device_scene, &kept, warm), picture(device_scene, nullptr, cold)) << "at " << time;
        EXPECT_EQ(warm.counts.voxels, cold.counts.voxels);
        follows += warm.stage("svo_update").gpu_seconds > 0 ? 'y' : 'n';
    }
    EXPECT_EQ(follows, "nnyy");
}

}  // namespace
}  // namespace photond::gpu_moving_voxels_test
