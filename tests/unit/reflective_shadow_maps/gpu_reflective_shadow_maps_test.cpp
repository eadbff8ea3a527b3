// Reflective shadow maps where their answer is known: where nothing stands between, and against lights whose visibility
// nobody asks.

#include <gtest/gtest.h>

#include "protocol/param_json.h"
#include "renderer/core/rng.h"
#include "renderer/methods/reflective_shadow_maps/reflective_shadow_maps_gpu.h"
#include "renderer/methods/registry.h"
#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/transport/emission_sampling.h"
#include "tests/support/open_scene.h"
#include "tests/support/path_render.h"

namespace photond::gpu_reflective_shadow_maps_test {
namespace {

using Rsm = ReflectiveShadowMapsGpu;

// Two-sided false alarms of 1e-6 among all checks of this program, a dozen.
constexpr double kMostErrors = 5.2;

test::RenderSettingsOf<Rsm> settings_for(RsmPattern pattern, uint32_t passes) {
    test::RenderSettingsOf<Rsm> settings;
    settings.size = {24, 18};
    settings.passes = passes;
    settings.seed = 7;
    settings.params.samples = 64;
    settings.params.map_resolution = 32;
    settings.params.pattern = pattern;
    settings.params.clamp_m2 = 0;
    settings.params.sampler = SamplerKind::Random;
    return settings;
}

test::RunningMean one_bounce_by_paths(const Scene& scene, uint32_t passes) {
    test::RenderSettings settings;
    settings.size = {24, 18};
    settings.passes = passes;
    settings.params.indirect_bounces = 1;
    settings.params.sampler = SamplerKind::Random;
    return test::indirect_of_passes(scene, settings);
}

class GpuRsmInTheOpen : public testing::TestWithParam<const char*> {};

TEST_P(GpuRsmInTheOpen, FluxIsTheTransportOfOneBounce) {
    const Scene scene = test::floor_and_wall(GetParam());
    const test::SceneOnDevice where(scene);
    const test::RunningMean paths = one_bounce_by_paths(scene, 400);
    const test::RunningMean flux = test::indirect_of_passes(where, settings_for(RsmPattern::Flux, 100));
    EXPECT_GT(paths.mean(), 0);
    EXPECT_LT(std::fabs(test::standard_errors_between(flux, paths)), kMostErrors)
        << flux.mean() << " against " << paths.mean();
    EXPECT_LT(kMostErrors * std::hypot(flux.standard_error(), paths.standard_error()), 0.1 * paths.mean())
        << "too noisy to notice a defect";
}
INSTANTIATE_TEST_SUITE_P(Lights, GpuRsmInTheOpen,
                         testing::Values("point", "spot", "directional", "area", "two-sided", "environment"),
                         [](const auto& of) { return test::test_name(of.param, of.index); });

/// What a light sends its numbers' way comes from the place of those numbers.
TEST(GpuRsmProjection, IsTheInverseOfEmission) {
    struct Question {
        uint32_t light;
        vec3 point;
    };
    RandomStream random(3, RandomDomain::Test, 0, 0);
    for (const char* name : {"point", "spot", "directional", "area", "two-sided", "environment"}) {
        const Scene scene = test::floor_and_wall(name);
        const test::SceneOnDevice where(scene);
        const EmissionSampler emission(scene);
        std::vector<Question> questions;
        std::vector<vec2> places;
        for (int i = 0; i < 400; ++i) {
            const auto light = static_cast<uint32_t>(random.next() * static_cast<float>(emission.lights()));
            const vec2 u_position = random.next_2d(), u_direction = random.next_2d();
            EmissionSample sample;
            if (!emission.sample_light(light, 1, u_position, u_direction, sample)) continue;
            const bool area = light < scene.triangle_lights.size();
            places.push_back(emission.guided_by_position(light) ? u_position : u_direction);
            // From an area light far enough that it is a point.
            questions.push_back({light, sample.ray.origin + (area ? 1e3f : 2.5f) * sample.ray.direction});
        }
        ASSERT_GT(questions.size(), 200u) << name;
        const test::Twin project("tests/gpu/rsm_projection.comp", &where.device_scene.set(),
                                 where.device_scene.specialization());
        const auto answers = project.run<vec3>(questions.size(), {{"questions", questions}});
        const bool local = std::string(name) != "environment";
        for (size_t i = 0; i < answers.size(); ++i) {
            ASSERT_EQ(answers[i].z != 0, local) << name;
            if (!local) continue;
            const vec2 off = glm::abs(vec2(answers[i]) - places[i]);
            EXPECT_LT(std::min(off.x, 1 - off.x), 3e-3f) << name << " " << places[i].x << " " << places[i].y;
            EXPECT_LT(std::min(off.y, 1 - off.y), 3e-3f) << name << " " << places[i].x << " " << places[i].y;
        }
    }
}

/// A small patch, lit evenly, far from the surface that it lights: all its texels bring about the same.
TEST(GpuRsm, PaperIsRightWhereAllTexelsBringTheSame) {
    Scene scene;
    MeshBuilder patch, floor;
    patch.quad({-0.1f, 5, -0.1f}, {0.1f, 5, -0.1f}, {0.1f, 5, 0.1f}, {-0.1f, 5, 0.1f});
    floor.quad({-0.3f, 0, -0.3f}, {-0.3f, 0, 0.3f}, {0.3f, 0, 0.3f}, {0.3f, 0, -0.3f});
    test::add(scene, patch.build(0), test::lambert(0.8f));
    test::add(scene, floor.build(0), test::lambert(0.5f));
    scene.cameras.push_back(look_at_camera({0, 1, 3}, {0, 0, 0}, {0, 1, 0}, 0.2f));
    PunctualLight light;
    light.kind = PunctualLight::Kind::Spot;
    light.position = {0, 4, 0};
    light.direction = {0, 1, 0};
    light.cos_outer = 0.999f;
    light.cos_inner = 1;
    light.intensity = Rgb(100);
    scene.punctual_lights.push_back(light);
    finish_scene(scene);
    const test::SceneOnDevice where(scene);
    const test::RunningMean flux = test::indirect_of_passes(where, settings_for(RsmPattern::Flux, 10));
    for (const float radius : {0.1f, 1.0f}) {
        test::RenderSettingsOf<Rsm> settings = settings_for(RsmPattern::Paper, 10);
        settings.params.sample_radius = radius;
        EXPECT_NEAR(test::indirect_of_passes(where, settings).mean(), flux.mean(), 0.05 * flux.mean()) << radius;
    }
    EXPECT_GT(flux.mean(), 0);
}

/// The two blocks stand between much that the walls would light.
TEST(GpuRsm, IsManyLightsWhoseVisibilityNobodyAsksAndTooBright) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<Rsm> settings = settings_for(RsmPattern::Flux, 100);
    settings.params.clamp_m2 = 0.01f;
    const test::RunningMean flux = test::indirect_of_passes(where, settings);
    test::RenderSettingsOf<SvoManyLights> same;
    same.size = settings.size;
    same.passes = settings.passes;
    same.seed = 8;
    same.params.bounces = 1;
    same.params.vpls = settings.params.samples;
    same.params.map_resolution = settings.params.map_resolution;
    same.params.visibility = VplVisibility::None;
    same.params.interleave = 1;
    same.params.clamp_m2 = settings.params.clamp_m2;
    same.params.repay = false;
    same.params.sampler = SamplerKind::Random;
    const test::RunningMean unasked = test::indirect_of_passes(scene, same);
    EXPECT_LT(std::fabs(test::standard_errors_between(flux, unasked)), kMostErrors)
        << flux.mean() << " against " << unasked.mean();
    const test::RunningMean paths = one_bounce_by_paths(scene, 100);
    EXPECT_GT(test::standard_errors_between(flux, paths), kMostErrors) << flux.mean() << " against " << paths.mean();
    // The paper's samples are near ones: what they bring is not the whole.
    settings.params.pattern = RsmPattern::Paper;
    const double paper = test::indirect_of_passes(where, settings).mean();
    EXPECT_GT(paper, 0.2 * paths.mean());
    EXPECT_LT(paper, 5 * paths.mean());
}

TEST(GpuRsm, SameBitsTwice) {
    for (const auto& [name, pattern] :
         {std::pair("cornell-box-glossy", RsmPattern::Paper), std::pair("cornell-box-spot", RsmPattern::Flux)}) {
        const Scene scene = make_builtin_scene(name);
        const test::SceneOnDevice where(scene);
        test::RenderSettingsOf<Rsm> settings = settings_for(pattern, 2);
        settings.params.clamp_m2.reset();
        const Film film = test::render(where, settings);
        EXPECT_EQ(film.pixel_hash(), test::render(where, settings).pixel_hash());
        EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
        EXPECT_GT(test::mean_of_layer(film, Layer::Indirect), 0);
    }
}

TEST(GpuRsm, DarkScenesAndNoBouncesAreBlack) {
    const Scene dark = test::floor_and_wall("none");
    const Scene lit = test::floor_and_wall("point");
    for (const Scene* scene : {&dark, &lit}) {
        const test::SceneOnDevice where(*scene);
        test::RenderSettingsOf<Rsm> settings = settings_for(RsmPattern::Paper, 2);
        if (scene == &lit) settings.params.bounces = 0;
        Stats stats;
        const Film film = test::render(where, settings, &stats);
        EXPECT_EQ(test::mean_of_layer(film, Layer::Indirect), 0);
        EXPECT_EQ(test::mean_of_layer(film, Layer::Direct) > 0, scene == &lit);
        EXPECT_TRUE(std::any_of(stats.skipped.begin(), stats.skipped.end(),
                                [](const Skipped& part) { return part.what == "virtual point lights"; }));
    }
    ReflectiveShadowMapsParams params;
    std::vector<Fault> faults;
    read_params(params, {{"bounces", 2}}, "", faults);
    ASSERT_EQ(faults.size(), 1u) << "one bounce is all it does";
    EXPECT_EQ(faults[0].pointer, "/bounces");
}

TEST(GpuRsm, TakesTheDeviceMemoryItSays) {
    const Scene scene = make_builtin_scene("cornell-box");
    const test::SceneOnDevice where(scene);
    test::RenderSettingsOf<Rsm> settings = settings_for(RsmPattern::Flux, 1);
    settings.size = {160, 120};
    settings.params.map_resolution = 128;
    test::expect_device_bytes_as_estimated(where, settings);
}

TEST(GpuRsm, IsInTheListOfMethodsForGpusAlone) {
    const MethodInfo* info = find_method("reflective_shadow_maps");
    ASSERT_NE(info, nullptr);
    EXPECT_EQ(info->devices(), std::vector<std::string_view>{"gpu"});
    EXPECT_EQ(info->make, nullptr);
    EXPECT_EQ(info->estimate_bytes, nullptr);
    EXPECT_NE(info->make_gpu(*info->make_params()), nullptr);
}

}  // namespace
}  // namespace photond::gpu_reflective_shadow_maps_test
