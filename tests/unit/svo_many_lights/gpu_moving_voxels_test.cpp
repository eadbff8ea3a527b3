// Frames of a moving scene on a GPU, one after the other: voxels that follow from the frame before make the picture of
// those that are built anew.

#include <gtest/gtest.h>

#include "renderer/methods/svo_many_lights/svo_many_lights_gpu.h"
#include "renderer/methods/visibility_filtering/visibility_filtering_gpu.h"
#include "renderer/methods/voxel_cone_tracing/voxel_cone_tracing_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/pose.h"
#include "renderer/voxels/kept_voxels.h"
#include "tests/support/gpu_render.h"
#include "tests/support/theatre.h"

namespace photond::gpu_moving_voxels_test {
namespace {

template <class M>
test::RenderSettingsOf<M> small_settings() {
    test::RenderSettingsOf<M> settings;
    settings.size = {24, 24};
    settings.passes = 1;
    settings.params.voxel_resolution = 64;
    return settings;
}

test::RenderSettingsOf<SvoManyLightsGpu> many_lights() {
    auto settings = small_settings<SvoManyLightsGpu>();
    settings.params.vpls = 64;
    settings.params.visibility = VplVisibility::Svo;
    settings.params.bounces = 2;
    settings.params.bounce_tracing = VplBounces::Voxels;
    return settings;
}

test::RenderSettingsOf<VoxelConeTracingGpu> cones() {
    auto settings = small_settings<VoxelConeTracingGpu>();
    settings.params.vpls = 1000;
    return settings;
}

test::RenderSettingsOf<VisibilityFilteringGpu> filtered_visibility() {
    auto settings = small_settings<VisibilityFilteringGpu>();
    settings.params.visibility = ProxyVisibility::Svo;
    settings.params.proxies = 1000;
    return settings;
}

template <class M>
std::string picture(const test::RenderSettingsOf<M>& settings, const gpu::DeviceScene& scene, KeptVoxels* kept,
                    Stats& stats) {
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
        context, settings, [&](M& method, uint32_t) { method.resolve(film); }, stats);
    return film.pixel_hash();
}

/// At each of the times, one after the other. `ways`: y where the voxels followed from those before, n where not.
template <class M>
void expect_same_pictures(const test::RenderSettingsOf<M>& settings, Scene scene, std::initializer_list<double> times,
                          const std::string& ways) {
    Stats stats;
    gpu::DeviceScene device_scene(test::gpu_device(), scene, stats);
    KeptVoxels kept;
    std::string follows;
    for (const double time : times) {
        const SceneChange change = pose_scene(scene, {0, time});
        kept.note(change);
        device_scene.follow(change, stats);
        Stats warm, cold;
        EXPECT_EQ(picture(settings, device_scene, &kept, warm), picture(settings, device_scene, nullptr, cold))
            << "at " << time;
        EXPECT_EQ(warm.counts.voxels, cold.counts.voxels);
        follows += warm.stage("svo_update").gpu_seconds > 0 ? 'y' : 'n';
    }
    EXPECT_EQ(follows, ways);
}

/// Where a block jumps, and where what swells has no room in the tree, so that a pass is made again.
template <class M>
void expect_same_pictures(const test::RenderSettingsOf<M>& settings) {
    expect_same_pictures(settings, make_builtin_scene("moving/teleport"), {0.2, 0.8, 0.49, 0.8}, "nnyy");
    expect_same_pictures(settings, test::make_swelling_lamp(), {0, 0.01, 0.02, 0.9}, "nnyy");
}

TEST(MovingVoxelsOnDevice, MakeThePictureOfThoseThatAreBuiltAnew) { expect_same_pictures(many_lights()); }
TEST(MovingVoxelsOnDevice, LightTheConesOfThoseThatAreBuiltAnew) { expect_same_pictures(cones()); }
TEST(MovingVoxelsOnDevice, HideWhatThoseHideThatAreBuiltAnew) { expect_same_pictures(filtered_visibility()); }

}  // namespace
}  // namespace photond::gpu_moving_voxels_test
