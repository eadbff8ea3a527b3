// Shadow maps of lights on the device against the host's: texels, and answers from the same texels.

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/gbuffer/light_depth_maps_gpu.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/transport/light_sampling.h"
#include "tests/support/gpu_twin.h"
#include "tests/support/lit_rooms.h"

namespace photond::gpu_light_depth_maps_test {
namespace {

constexpr uint32_t kResolution = 48, kPcf = 3;

// Of tests/gpu/light_depth.comp.
struct Question {
    vec3 position, normal;
    vec2 u;
    uint32_t source;
};
struct Answer {
    uint32_t seen;
    vec2 tap_number;
};

class GpuLightDepthMaps : public testing::Test {
protected:
    GpuLightDepthMaps() : scene_(test::lit_room()), device_scene_(test::gpu_device(), scene_) {
        MemoryBudget budget;
        Stats stats;
        intersector_ = make_embree_intersector(scene_, budget, stats);
        maps_ = std::make_unique<LightDepthMaps>(scene_, *intersector_, kResolution, kPcf, stats);
    }

    const Scene scene_;
    const gpu::DeviceScene device_scene_;
    std::unique_ptr<Intersector> intersector_;
    std::unique_ptr<LightDepthMaps> maps_;
};

// A ray that passes an edge within rounding meets what is on either side of it.
TEST_F(GpuLightDepthMaps, TexelsAreTheHostsButForSilhouettes) {
    Stats stats;
    LightDepthMapsGpu maps(device_scene_, kResolution, kPcf, stats);
    const size_t texels = maps_->depths_m().size();
    EXPECT_EQ(stats.counts.shadow_rays, texels);
    EXPECT_EQ(stats.stages.at(0).name, "shadow_maps");
    EXPECT_GT(stats.stages.at(0).gpu_seconds, 0);
    EXPECT_EQ(maps.constants().bytes() + maps.maps().bytes() + maps.depths().bytes(),
              LightDepthMapsGpu::device_bytes(scene_, kResolution));
    const std::vector<float> depths_m = gpu::read_back<float>(test::gpu_device(), maps.depths(), texels);
    size_t apart = 0, met = 0;
    for (size_t i = 0; i < texels; ++i) {
        const float expected = maps_->depths_m()[i];
        met += expected < kInfinity ? 1 : 0;
        apart += expected == depths_m[i] || std::fabs(depths_m[i] - expected) <= 2e-5f * expected ? 0 : 1;
    }
    EXPECT_GT(met, texels / 4) << "something is met";
    EXPECT_LT(met, texels) << "and somewhere nothing";
    EXPECT_LE(apart, texels / 1000);
}

TEST_F(GpuLightDepthMaps, AnswersAreTheHosts) {
    const std::vector<test::FacingPoint> points = test::facing_points(scene_, *intersector_, 20000, 0.01f, 1);
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<Question> questions;
    for (const test::FacingPoint& point : points)
        questions.push_back(
            {point.position, point.normal, random.next_2d(), light_source_of_punctual(scene_, point.light)});
    questions.push_back({vec3(0), vec3(0, 1, 0), vec2(0.5f), 0});  // an instance
    questions.push_back({vec3(0), vec3(0, 1, 0), vec2(0.5f), light_source_of_environment(scene_)});
    const std::vector<Answer> answers =
        test::run_twin<Answer>("tests/gpu/light_depth.comp", questions.size(),
                               {{"light_depth_constants", std::span(&maps_->layout().constants, 1)},
                                {"light_depth_maps", maps_->layout().maps},
                                {"light_depths_m", maps_->depths_m()},
                                {"questions", questions}});
    size_t apart = 0, lit = 0;
    for (size_t i = 0; i < questions.size(); ++i) {
        const Question& q = questions[i];
        const auto expected = static_cast<uint32_t>(maps_->seen(q.source, q.position, q.normal, q.u));
        ASSERT_EQ(answers[i].seen == 2, expected == 2) << "whether anything is known";
        apart += answers[i].seen != expected ? 1 : 0, lit += expected == 0 ? 1 : 0;
        const vec2 number = LightDepthMaps::tap_number(q.position, q.source, static_cast<uint32_t>(i));
        ASSERT_EQ(answers[i].tap_number, number);
    }
    EXPECT_GT(lit, questions.size() / 4);
    EXPECT_LT(lit, 9 * questions.size() / 10);
    EXPECT_LE(apart, questions.size() / 1000) << "a place at a texel's border may be on either side";
}

TEST(GpuLightDepthMapsWithoutLights, HoldNothing) {
    Scene scene = make_builtin_scene("cornell-box");
    scene.punctual_lights.clear();
    finish_scene(scene);
    const gpu::DeviceScene device_scene(test::gpu_device(), scene);
    Stats stats;
    LightDepthMapsGpu maps(device_scene, 1024, kPcf, stats);
    EXPECT_EQ(stats.counts.shadow_rays, 0u);
    EXPECT_EQ(maps.constants().bytes() + maps.maps().bytes() + maps.depths().bytes(),
              LightDepthMapsGpu::device_bytes(scene, 1024));
}

}  // namespace
}  // namespace photond::gpu_light_depth_maps_test
