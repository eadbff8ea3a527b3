// Rays through the middles of pixels on a device: begun before other work, taken after it.

#include <gtest/gtest.h>

#include <cstring>

#include "renderer/backends/gpu/device_intersector.h"
#include "renderer/gbuffer/reprojection.h"
#include "renderer/scene/builtin_scenes.h"
#include "tests/support/gpu_twin.h"

namespace photond::gpu_reprojection_test {
namespace {

constexpr Size2 kSize{320, 210};  // more pixels than one submission has

bool same(const std::vector<Hit>& a, const std::vector<Hit>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Hit)) == 0;
}

TEST(CentreHitsOnDevice, AreThoseOfRaysThatAreTracedAtOnce) {
    const Scene scene = make_builtin_scene("moving/cornell-box");
    const gpu::DeviceScene device_scene(test::gpu_device(), scene);
    const gpu::DeviceIntersector rays(device_scene);
    MemoryBudget budget;
    const RenderContext context{scene, &rays, {find_camera(scene, ""), kSize, PixelFilter::Box, {}}, 1, budget};
    std::vector<Ray> centres;
    for (size_t i = 0; i < kSize.pixels(); ++i)
        centres.push_back(
            camera_ray(context.view.camera, kSize, vec2(i % kSize.width, i / kSize.width) + vec2(0.5f), vec2(0.5f)));
    const uint64_t held = test::gpu_device().memory().used_bytes();
    const std::unique_ptr<HitsToCome> begun = begin_centre_hits(context);
    std::vector<Hit> at_once(centres.size());
    rays.closest_hits(centres, at_once, Coherence::Coherent);
    EXPECT_GT(std::ranges::count_if(at_once, &Hit::valid), 40'000);
    EXPECT_GE(test::gpu_device().memory().used_bytes(), held + kSize.pixels() * (sizeof(Ray) + sizeof(Hit)));
    EXPECT_TRUE(same(begun->take(), at_once));
}

TEST(CentreHitsOnDevice, AreLeftWhereNobodyTakesThem) {
    const Scene scene = make_builtin_scene("cornell-box");
    const gpu::DeviceScene device_scene(test::gpu_device(), scene);
    const gpu::DeviceIntersector rays(device_scene);
    const uint64_t batches = rays.batch_bytes();
    const std::vector<Ray> away(100'000, Ray{vec3(0, 1, 9), vec3(0, 0, 1)});
    (void)rays.closest_hit(away[0]);
    const uint64_t held = test::gpu_device().memory().used_bytes();
    (void)rays.begin_closest_hits(away, Coherence::Coherent);
    EXPECT_EQ(test::gpu_device().memory().used_bytes(), held);
    EXPECT_EQ(rays.bytes(), batches);
    for (const Hit& hit : rays.begin_closest_hits(away, Coherence::Coherent)->take()) ASSERT_FALSE(hit.valid());
    EXPECT_TRUE(rays.begin_closest_hits({}, Coherence::Coherent)->take().empty());
}

}  // namespace
}  // namespace photond::gpu_reprojection_test
