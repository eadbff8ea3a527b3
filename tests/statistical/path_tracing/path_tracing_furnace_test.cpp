// Closed surfaces and uniform surroundings, where the answer is known in closed form. Chance of a false alarm 1e-6 for
// the file's 26 checks together (Sidak); each test says what relative error it must notice.

#include <gtest/gtest.h>

#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/environment_sampling.h"
#include "tests/support/path_render.h"
#include "tests/support/scene_parts.h"
#include "tests/support/statistics.h"

namespace photond::path_tracing_furnace_test {
namespace {

using test::lambert;

constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 26;

/// `measure(seed)` must have the mean `exact`, and vary so little that `must_detect` (relative) would be noticed.
template <class Measure>
void expect_mean(double exact, double must_detect, const Measure& measure) {
    const test::Interval measured =
        test::interval_when_narrow(0.5 * must_detect * exact, 16, kFalseAlarm, kChecks, measure);
    EXPECT_LE(std::abs(measured.mean - exact), std::max(measured.half_width, 2e-6 * exact))
        << "measured " << measured.mean << ", exact " << exact;
    EXPECT_LE(2 * measured.half_width, must_detect * exact) << "too noisy to notice a defect";
}

/// Inside of a sphere of this material, seen from its centre.
Scene closed_sphere(const Material& wall) {
    Scene scene;
    scene.materials = {wall};
    scene.meshes = {make_icosphere(3, 0)};
    for (uvec3& t : scene.meshes[0].triangles) std::swap(t.y, t.z);
    scene.instances = {{}};
    Camera camera;
    camera.yfov = 1.2f;
    scene.cameras = {camera};
    finish_scene(scene);
    return scene;
}

double mean_layer(const Scene& scene, Layer layer, uint64_t seed, uint32_t passes,
                  std::optional<uint32_t> bounces = {}) {
    test::RenderSettings settings;
    settings.size = {24, 24};
    settings.passes = passes;
    settings.seed = seed;
    settings.params.indirect_bounces = bounces;
    return test::mean_of(test::render(scene, settings).resolve(layer));
}

double mean_beauty(const Scene& scene, uint64_t seed, uint32_t passes) {
    test::RenderSettings settings;
    settings.size = {24, 24};
    settings.passes = passes;
    settings.seed = seed;
    return test::mean_of(test::render(scene, settings).resolve_beauty());
}

// Radiance inside a closed surface that emits L and reflects `albedo` is L / (1 - albedo) everywhere.
TEST(Furnace, LambertReachesTheClosedForm) {
    constexpr std::pair<float, double> kAlbedoAndMustDetect[] = {
        {0.0f, 0.001}, {0.2f, 0.02}, {0.5f, 0.03}, {0.8f, 0.08}, {0.95f, 0.12}};
    for (const auto& [albedo, must_detect] : kAlbedoAndMustDetect) {
        SCOPED_TRACE(albedo);
        const Scene scene = closed_sphere(lambert(albedo, 1));
        expect_mean(1.0 / (1.0 - double(albedo)), must_detect,
                    [&](uint64_t seed) { return mean_beauty(scene, seed, 8); });
    }
    const Scene builtin = make_builtin_scene("furnace");
    expect_mean(2, 0.03, [&](uint64_t seed) { return mean_beauty(builtin, seed, 8); });
}

// Light of n scatterings is albedo^n: emitted 1, direct albedo, indirect the rest up to the bounces asked for.
TEST(Furnace, BouncesAreCountedAsTheConventionsSay) {
    constexpr double kAlbedo = 0.6;
    const Scene scene = closed_sphere(lambert(float(kAlbedo), 1));
    expect_mean(1, 1e-3, [&](uint64_t seed) { return mean_layer(scene, Layer::Emitted, seed, 4); });
    expect_mean(kAlbedo, 0.02, [&](uint64_t seed) { return mean_layer(scene, Layer::Direct, seed, 16); });
    EXPECT_EQ(mean_layer(scene, Layer::Indirect, 1, 4, 0), 0);
    double exact = 0;
    for (const uint32_t bounces : {1u, 2u, 3u}) {
        exact += std::pow(kAlbedo, bounces + 1);
        expect_mean(exact, 0.05, [&](uint64_t seed) { return mean_layer(scene, Layer::Indirect, seed, 16, bounces); });
    }
}

// Seen from the centre every ray meets the mirror head-on, so its reflectance is F0; all light has met deltas only.
TEST(Furnace, MirrorReachesTheClosedForm) {
    Material mirror;
    mirror.base_color = Rgb(0.5f);
    mirror.metallic = 1;
    mirror.roughness = 0;
    mirror.emission = Rgb(1);
    Scene scene = closed_sphere(mirror);
    expect_mean(2, 0.02, [&](uint64_t seed) { return mean_layer(scene, Layer::Emitted, seed, 16); });
    EXPECT_EQ(mean_layer(scene, Layer::Direct, 1, 4), 0);
    EXPECT_EQ(mean_layer(scene, Layer::Indirect, 1, 4), 0);
}

/// A ball in surroundings of radiance 1, filling most of the image.
Scene ball_in_the_open(const Material& material, bool smooth) {
    Scene scene;
    scene.materials = {material};
    scene.meshes = {make_icosphere(4, 0)};
    if (smooth) scene.meshes[0].normals = scene.meshes[0].positions;
    scene.instances = {{}};
    Environment sky;
    sky.map.size = {8, 4};
    sky.map.radiance.assign(32, Rgb(1));
    scene.environment = sky;
    Camera camera;
    camera.position = vec3(0, 0, 4);
    camera.yfov = 0.3f;  // the ball's outline lies at 0.25 rad: every pixel shows the ball
    scene.cameras = {camera};
    finish_scene(scene);
    return scene;
}

TEST(Furnace, ConvexLambertShowsItsAlbedo) {
    const Scene scene = ball_in_the_open(lambert(0.7f, 0), false);
    expect_mean(0.7, 0.01, [&](uint64_t seed) { return mean_layer(scene, Layer::Direct, seed, 16); });
}

// A floor below a sky whose zenith is dimmer than its mean, where no light samples go: the last scattering's ray finds
// that part, also where none may follow. What a Lambert floor of reflectance r shows is r / pi times the irradiance,
// and that the sum over the rows of bands of one radiance, but for the blur between them: by quadrature of the lookup.
TEST(Furnace, TheSkysDimPartsArriveAtTheLastBounce) {
    Scene scene;
    scene.materials = {lambert(0.6f, 0)};
    scene.meshes = {MeshBuilder().quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2}).build(0)};
    scene.instances = {{}};
    Environment sky;
    sky.map.size = {8, 8};
    for (uint32_t i = 0; i < 64; ++i) sky.map.radiance.push_back(Rgb(i / 8 == 3 ? 5.0f : 0.8f));
    scene.environment = sky;
    Camera camera;
    camera.position = vec3(0, 3, 0);
    camera.forward = vec3(0, -1, 0);
    camera.right = vec3(1, 0, 0);
    camera.up = vec3(0, 0, -1);
    camera.yfov = 0.4f;
    scene.cameras = {camera};
    finish_scene(scene);
    const EnvironmentSampler lookup(*scene.environment);
    constexpr int kRows = 20'000;
    double irradiance = 0;
    for (int i = 0; i < kRows; ++i) {
        const double cosine = (i + 0.5) / kRows;
        const vec3 wi(static_cast<float>(std::sqrt(1 - cosine * cosine)), static_cast<float>(cosine), 0);
        irradiance += 2 * M_PI * cosine * double{mean(lookup.radiance(wi))} / kRows;
    }
    const EnvironmentSampler light_samples(*scene.environment, EnvironmentDensity::Compensated);
    ASSERT_EQ(light_samples.pdf(vec3(0, 1, 0)), 0);
    for (const std::optional<uint32_t> bounces : {std::optional<uint32_t>(), std::optional<uint32_t>(0)})
        expect_mean(0.6 * irradiance / M_PI, 0.01,
                    [&](uint64_t seed) { return mean_layer(scene, Layer::Direct, seed, 64, bounces); });
}

// Smooth glass loses nothing: in uniform surroundings it cannot be seen.
TEST(Furnace, SmoothGlassIsInvisibleInUniformLight) {
    Material glass;
    glass.metallic = 0;
    glass.roughness = 0;
    glass.transmission = 1;
    glass.solid = true;
    const Scene scene = ball_in_the_open(glass, false);
    expect_mean(1, 0.01, [&](uint64_t seed) { return mean_layer(scene, Layer::Emitted, seed, 16); });
}

TEST(Furnace, RoughMetalReflectsNoMoreThanArrives) {
    for (const float roughness : {0.1f, 0.4f, 1.0f}) {
        Material metal;
        metal.base_color = Rgb(1);
        metal.metallic = 1;
        metal.roughness = roughness;
        const Scene scene = ball_in_the_open(metal, true);
        const auto measure = [&](uint64_t seed) { return mean_beauty(scene, seed, 8); };
        const test::Interval measured = test::interval_when_narrow(0.02, 16, kFalseAlarm, kChecks, measure);
        EXPECT_LE(measured.mean - measured.half_width, 1.0) << "roughness " << roughness;
        // At alpha 1 and normal incidence single scattering keeps 1 - ln 2 = 0.307 (D = 1/pi, G = 2c/(1 + c)).
        EXPECT_GE(measured.mean, 0.3) << "roughness " << roughness;
        EXPECT_LE(measured.half_width, 0.02);
    }
}

}  // namespace
}  // namespace photond::path_tracing_furnace_test
