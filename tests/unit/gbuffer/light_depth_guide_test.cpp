// Direct light by the lights' depth maps against direct light by shadow rays, as the walk from the eye finds it.

#include "renderer/gbuffer/light_depth_guide.h"

#include <gtest/gtest.h>

#include "tests/support/lit_rooms.h"
#include "tests/support/render.h"

namespace photond::light_depth_guide_test {
namespace {

class NoPoints final : public VisiblePointSink {
public:
    void take(std::span<const LambertVisiblePoint>, std::span<const VisiblePoint>) override {}
};

constexpr Size2 kSize{64, 48};
constexpr uint32_t kPasses = 16;

struct Direct {
    std::vector<double> sums;  // by pixel and channel
    Counts counts;
};

Direct direct_light(const Scene& scene, const Intersector& intersector, const LightDepthMaps* maps) {
    MemoryBudget budget;
    const RenderContext context{scene, &intersector, View{scene.cameras.at(0), kSize, PixelFilter::Box, {}}, 1, budget};
    const EyeScene shared(context, SamplerKind::Sobol, 1);
    SpecularWalk walk(kSize.width);
    PassImage image(kSize, {});
    Direct direct{std::vector<double>(3 * kSize.pixels()), {}};
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
        const PassSampler sampler(SamplerKind::Sobol, 1, RandomDomain::Camera, pass);
        std::optional<LightDepthGuide> guide;
        if (maps) guide.emplace(*maps, sampler, pass);
        NoPoints sink;
        EyeSeconds seconds;
        walk.trace_tile(shared, {.guide = guide ? &*guide : nullptr}, {sampler, {&sampler, 1}},
                        Tile{0, 0, kSize.width, kSize.height}, image, direct.counts, seconds, CancelToken{}, sink);
        for (size_t i = 0; i < direct.sums.size(); ++i) direct.sums[i] += image.of<Layer::Direct>()[i / 3][int(i % 3)];
    }
    return direct;
}

/// The room, with a lamp that has an area where asked for.
Scene room(bool lamp) {
    Scene scene = test::lit_room();
    if (lamp)
        test::add(scene,
                  MeshBuilder().quad({-0.4f, 2.9f, 0}, {-0.4f, 2.9f, 0.4f}, {0, 2.9f, 0.4f}, {0, 2.9f, 0}).build(0),
                  test::emitting(Rgb(10), true));
    Camera camera;
    camera.position = {0, 1.6f, 5.5f};
    camera.yfov = 0.8f;
    scene.cameras = {camera};
    finish_scene(scene);
    return scene;
}

// The same points and light samples: only shadows differ. Of 3 percent of the light at most the maps of that resolution
// are wrong (light_depth_maps_test.cpp), falsely lit and falsely dark alike.
TEST(LightDepthGuide, DirectLightIsThatOfShadowRaysButForTheMapsErrors) {
    for (const bool lamp : {false, true}) {
        const Scene scene = room(lamp);
        MemoryBudget budget;
        Stats stats;
        const std::unique_ptr<Intersector> intersector = make_embree_intersector(scene, budget, stats);
        const LightDepthMaps maps(scene, *intersector, 512, 3, stats);
        const Direct by_rays = direct_light(scene, *intersector, nullptr);
        const Direct by_maps = direct_light(scene, *intersector, &maps);
        double light = 0, difference = 0, apart = 0;
        for (size_t i = 0; i < by_rays.sums.size(); ++i) {
            light += by_rays.sums[i];
            difference += by_maps.sums[i] - by_rays.sums[i];
            apart += std::abs(by_maps.sums[i] - by_rays.sums[i]);
        }
        EXPECT_GT(light, 0);
        EXPECT_GT(apart, 0) << "the maps are asked";
        EXPECT_LE(apart, 0.03 * light);
        EXPECT_LE(std::abs(difference), 0.01 * light);
        EXPECT_GT(by_rays.counts.shadow_rays, kSize.pixels());
        if (lamp) {
            EXPECT_GT(by_maps.counts.shadow_rays, 0u) << "what has an area keeps its rays";
            EXPECT_LT(by_maps.counts.shadow_rays, by_rays.counts.shadow_rays);
        } else {
            EXPECT_EQ(by_maps.counts.shadow_rays, 0u);
        }
    }
}

}  // namespace
}  // namespace photond::light_depth_guide_test
