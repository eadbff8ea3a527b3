#pragma once
// Light paths start as they should: flux against closed forms, places and directions by chi-square, and what photons
// bring to a patch against what the host's sampler of direct light says arrives there. For whoever samples: the type is
// HostEmission (light_samples.h) or one with its face.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/emission.h"
#include "renderer/transport/environment_sampling.h"
#include "tests/support/light_samples.h"
#include "tests/support/scene_parts.h"
#include "tests/support/statistics.h"

namespace photond::test {

template <class Emission>
class EmissionFlux : public testing::Test {};
TYPED_TEST_SUITE_P(EmissionFlux);
template <class Emission>
class EmissionDirections : public testing::Test {};
TYPED_TEST_SUITE_P(EmissionDirections);
template <class Emission>
class EmissionAgreement : public testing::Test {};
TYPED_TEST_SUITE_P(EmissionAgreement);

inline constexpr double kEmissionFalseAlarm = 1e-6;  // of each test as a whole
inline constexpr double kPiD = 3.14159265358979323846;

/// A floor of 2 m by 2 m at height 0, front side up. Its patch of 1 m by 1 m in the middle is what photons are counted
/// on.
inline Scene with_floor() {
    Scene scene;
    scene.name = "emission";
    Material grey;
    grey.base_color = Rgb(0.5f);
    add(scene, MeshBuilder().quad(vec3(-1, 0, 1), vec3(1, 0, 1), vec3(1, 0, -1), vec3(-1, 0, -1)).build(0), grey);
    return scene;
}
inline constexpr float kHalfPatch = 0.5f;

inline Scene with_punctual(const PunctualLight& light) {
    Scene scene = with_floor();
    scene.punctual_lights.push_back(light);
    finish_scene(scene);
    return scene;
}

inline PunctualLight point_light(const Rgb& intensity, float range_m = kInfinity) {
    PunctualLight light;
    light.intensity = intensity;
    light.position = vec3(0.3f, 1, -0.2f);
    light.range_m = range_m;
    return light;
}

inline PunctualLight spot_light(float inner, float outer) {
    PunctualLight light = point_light(Rgb(3, 2, 1));
    light.kind = PunctualLight::Kind::Spot;
    light.direction = glm::normalize(vec3(-0.2f, -1, 0.3f));
    light.cos_inner = std::cos(inner);
    light.cos_outer = std::cos(outer);
    return light;
}

inline PunctualLight sun() {
    PunctualLight light;
    light.kind = PunctualLight::Kind::Directional;
    light.intensity = Rgb(3, 2, 1);
    light.direction = glm::normalize(vec3(0.4f, -1, 0.2f));
    return light;
}

/// A triangle above the floor that looks down, or up and down.
inline Scene with_triangle(const Material& material, bool facing_up = false) {
    Scene scene = with_floor();
    const vec3 a(-0.4f, 0.9f, -0.3f), b(0.5f, 1.1f, -0.2f), c(0.1f, 1, 0.6f);
    const bool up = glm::cross(b - a, c - a).y > 0;
    add(scene, MeshBuilder().triangle(a, up == facing_up ? b : c, up == facing_up ? c : b).build(0), material);
    finish_scene(scene);
    return scene;
}

/// Emission varies over the triangle, and a part of its texels are black.
inline Scene with_textured_triangle() {
    Scene scene = with_floor();
    Texture texture;
    texture.size = {4, 4};
    for (uint32_t i = 0; i < 16; ++i)
        texture.texels.push_back(
            u8vec4(i % 3 == 0 ? 0 : 255 - 10 * i, i % 3 == 0 ? 0 : 40 + 10 * i, i % 3 == 0 ? 0 : 128, 255));
    scene.textures.push_back(texture);
    Material material = emitting(Rgb(5, 4, 3));
    material.emission_texture.texture = 0;
    add(scene,
        MeshBuilder()
            .quad(vec3(-0.5f, 1, -0.5f), vec3(0.5f, 1, -0.5f), vec3(0.5f, 1, 0.5f), vec3(-0.5f, 1, 0.5f))
            .build(0, true),
        material);
    finish_scene(scene);
    return scene;
}

inline Scene with_environment() {
    Scene scene = with_floor();
    Environment environment;
    environment.map.size = {16, 8};
    for (uint32_t i = 0; i < 128; ++i) {
        const float x = static_cast<float>(i % 16), y = static_cast<float>(i / 16);
        environment.map.radiance.push_back(Rgb(1 + x, 1 + y, 3) * (i == 37 ? 20.0f : 0.3f));
    }
    environment.scale = 0.7f;
    environment.rotation = 0.6f;
    scene.environment = environment;
    finish_scene(scene);
    return scene;
}

/// Samples by the numbers of one stream.
template <class Emission>
std::vector<std::optional<EmissionSample>> draw_emission(const Emission& sampler, size_t count, uint64_t stream) {
    RandomStream random(7, RandomDomain::Test, 0, stream);
    return sampler.sample(emission_queries(count, random));
}

// --- flux -------------------------------------------------------------------------------------------------------

/// The mean of the samples' power is the flux; for lights of one kind and constant radiance, every sample's is.
template <class Emission>
void expect_flux(const Scene& scene, const dvec3& flux_w, bool constant) {
    const Emission sampler(scene);
    ASSERT_EQ(sampler.lights(),
              scene.triangle_lights.size() + scene.punctual_lights.size() + (scene.environment ? 1 : 0));
    const double total_power_w = EmissionSampler(scene).total_power_w();
    EXPECT_NEAR(total_power_w, (flux_w.x + flux_w.y + flux_w.z) / 3, (constant ? 1e-5 : 0.03) * total_power_w);
    constexpr uint32_t kSamples = 200000;
    RunningMean channel[3];
    for (const auto& sample : draw_emission(sampler, kSamples, 1)) {
        const Rgb power_w = sample ? sample->power_w : Rgb(0);
        for (int c = 0; c < 3; ++c) channel[c].add(power_w[c]);
    }
    const double z = two_sided_z(share_of_false_alarm(kEmissionFalseAlarm, 3));
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(channel[c].mean(), flux_w[c], z * channel[c].standard_error() + 2e-6 * flux_w[c])
            << "channel " << c;
        EXPECT_LT(z * channel[c].standard_error(), (constant ? 1e-5 : 0.02) * flux_w[c])
            << "too noisy to notice a defect";
    }
}

TYPED_TEST_P(EmissionFlux, Triangle) {
    const Scene scene = with_triangle(emitting(Rgb(3, 2, 1)));
    expect_flux<TypeParam>(scene, dvec3(3, 2, 1) * kPiD * double{scene.triangle_lights[0].area_m2}, true);
    const Scene both = with_triangle(emitting(Rgb(3, 2, 1), true));
    expect_flux<TypeParam>(both, dvec3(3, 2, 1) * 2.0 * kPiD * double{both.triangle_lights[0].area_m2}, true);
}

TYPED_TEST_P(EmissionFlux, TexturedTriangles) {
    const Scene scene = with_textured_triangle();
    constexpr uint32_t kRows = 600;
    dvec3 flux_w(0);
    for (uint32_t light = 0; light < 2; ++light)
        for (uint32_t row = 0; row < kRows; ++row)
            for (uint32_t column = 0; column + row < kRows; ++column) {
                const TriangleLight& triangle = scene.triangle_lights[light];
                const bool upper = column + row + 1 < kRows;
                const float u = (static_cast<float>(column) + 1.0f / 3) / kRows;
                const float v = (static_cast<float>(row) + 1.0f / 3) / kRows;
                const float step = 1.0f / (3 * kRows);
                Rgb sum = emitted_radiance(scene, {triangle.instance, triangle.triangle, u, v}, true);
                if (upper)
                    sum += emitted_radiance(scene, {triangle.instance, triangle.triangle, u + step, v + step}, true);
                flux_w += dvec3(sum) * (kPiD * triangle.area_m2 / (double{kRows} * kRows));
            }
    expect_flux<TypeParam>(scene, flux_w, false);
}

TYPED_TEST_P(EmissionFlux, PunctualLights) {
    expect_flux<TypeParam>(with_punctual(point_light(Rgb(3, 2, 1))), dvec3(3, 2, 1) * 4.0 * kPiD, true);
    expect_flux<TypeParam>(with_punctual(point_light(Rgb(3, 2, 1), 2)), dvec3(3, 2, 1) * 4.0 * kPiD, true);
    for (const auto& [inner, outer] : {std::pair{0.0f, 0.5f}, std::pair{0.3f, 0.8f}, std::pair{0.1f, 1.5f}}) {
        const double i = std::cos(double{inner}), o = std::cos(double{outer});
        expect_flux<TypeParam>(with_punctual(spot_light(inner, outer)),
                               dvec3(3, 2, 1) * 2.0 * kPiD * ((1 - i) + (i - o) / 3), true);
    }
    const Scene scene = with_punctual(sun());
    const double radius = std::sqrt(2.0);
    expect_flux<TypeParam>(scene, dvec3(3, 2, 1) * kPiD * radius * radius, true);
}

/// Where the cosines are nearer than 0.001 the ramp has that width, in the photons as in direct light; also where the
/// axis lies on it.
TYPED_TEST_P(EmissionFlux, SpotsWithoutRamp) {
    for (const float angle : {0.4f, 0.03f}) {
        const double outer = static_cast<double>(std::cos(angle));
        const double top = std::min(1.0, (1 - outer) / 0.001);
        const double flux = 2 * kPiD * (std::max(0.0, 1 - outer - 0.001) + 0.001 * top * top * top / 3);
        Scene scene = with_punctual(spot_light(angle, angle));
        EXPECT_NEAR(EmissionSampler(scene).total_power_w(), 2 * flux, 1e-3 * flux);
        expect_flux<TypeParam>(scene, dvec3(3, 2, 1) * flux, true);
    }
}

TYPED_TEST_P(EmissionFlux, Environment) {
    const Scene scene = with_environment();
    const EnvironmentSampler radiance(*scene.environment);
    constexpr uint32_t kRows = 400;
    dvec3 flux_w(0);
    for (uint32_t row = 0; row < kRows; ++row)
        for (uint32_t column = 0; column < 2 * kRows; ++column) {
            const double polar = kPiD * (row + 0.5) / kRows, azimuth = kPiD * (column + 0.5) / kRows;
            const vec3 wi(
                dvec3(std::sin(polar) * std::cos(azimuth), std::cos(polar), std::sin(polar) * std::sin(azimuth)));
            flux_w += dvec3(radiance.radiance(wi)) * (std::sin(polar) * kPiD * kPiD / (double{kRows} * kRows));
        }
    expect_flux<TypeParam>(scene, flux_w * kPiD * 2.0, false);
}

TYPED_TEST_P(EmissionFlux, ManyLightsOfAllKinds) {
    Scene scene = with_triangle(emitting(Rgb(3, 2, 1)));
    scene.punctual_lights = {point_light(Rgb(0.1f, 0.2f, 0.3f)), spot_light(0.3f, 0.8f), sun(), point_light(Rgb(0)),
                             point_light(Rgb(1e-9f))};
    finish_scene(scene);
    const TypeParam sampler(scene);
    const double i = std::cos(0.3), o = std::cos(0.8);
    const dvec3 flux_w = dvec3(3, 2, 1) * kPiD * double{scene.triangle_lights[0].area_m2} +
                         dvec3(0.1, 0.2, 0.3) * 4.0 * kPiD + dvec3(3, 2, 1) * 2.0 * kPiD * ((1 - i) + (i - o) / 3) +
                         dvec3(3, 2, 1) * kPiD * double{scene.bounds.radius()} * double{scene.bounds.radius()};
    expect_flux<TypeParam>(scene, flux_w, false);

    // Each light is chosen as often as it says; one without power never, the weakest with some probability.
    std::vector<double> observed(sampler.lights()), expected;
    constexpr uint32_t kSamples = 100000;
    double sum = 0;
    for (uint32_t light = 0; light < sampler.lights(); ++light) {
        expected.push_back(double{sampler.probability(light)} * kSamples);
        sum += sampler.probability(light);
    }
    EXPECT_EQ(sum, 1);
    EXPECT_EQ(sampler.probability(4), 0);
    EXPECT_GT(sampler.probability(5), 0);
    for (const auto& sample : draw_emission(sampler, kSamples, 2)) {
        ASSERT_TRUE(sample);
        ++observed.at(sample->light);
    }
    EXPECT_GT(chi_square_probability(observed, expected), kEmissionFalseAlarm);
    for (uint32_t light = 0; light < sampler.lights(); ++light)
        EXPECT_EQ(sampler.guided_by_position(light), light == 3) << light;
}

TYPED_TEST_P(EmissionFlux, DarkAndEmptyScenes) {
    Scene dark = with_floor();
    finish_scene(dark);
    Scene black = with_punctual(point_light(Rgb(0)));
    Scene empty;
    empty.punctual_lights.push_back(point_light(Rgb(1)));
    empty.punctual_lights.push_back(sun());
    finish_scene(empty);
    for (const Scene* scene : {&dark, &black, &empty}) {
        EXPECT_EQ(EmissionSampler(*scene).total_power_w(), 0);
        const TypeParam sampler(*scene);
        EXPECT_FALSE(sampler.sample({{0.5f, vec2(0.5f), vec2(0.5f)}})[0]);
        for (uint32_t light = 0; light < sampler.lights(); ++light)
            EXPECT_FALSE(sampler.sample({{0, vec2(0.5f), vec2(0.5f), light, 1}})[0]);
    }
}

// --- places and directions --------------------------------------------------------------------------------------

/// Chi-square of cell(sample) over equally likely cells.
template <class Emission>
void expect_even(const Emission& sampler, uint32_t cells, uint64_t stream,
                 const std::function<uint32_t(const EmissionSample&)>& cell, uint32_t checks) {
    constexpr uint32_t kSamples = 200000;
    std::vector<double> observed(cells), expected(cells, double{kSamples} / cells);
    for (const auto& sample : draw_emission(sampler, kSamples, stream)) {
        ASSERT_TRUE(sample);
        ASSERT_NEAR(glm::length(sample->ray.direction), 1, 1e-5);
        ++observed.at(cell(*sample));
    }
    EXPECT_GT(chi_square_probability(observed, expected), share_of_false_alarm(kEmissionFalseAlarm, checks));
}

/// Cell of a pair in [0, 1]^2, kSide x kSide.
inline constexpr uint32_t kSide = 12;
inline uint32_t square_cell(double x, double y) {
    const auto index = [](double t) { return std::min(static_cast<uint32_t>(std::max(t, 0.0) * kSide), kSide - 1); };
    return index(y) * kSide + index(x);
}
inline double turn(double y, double x) { return std::atan2(y, x) / (2 * kPiD) + 0.5; }

TYPED_TEST_P(EmissionDirections, TrianglesSendCosineDistributedLightFromEvenPlaces) {
    for (const bool two_sided : {false, true}) {
        const Scene scene = with_triangle(emitting(Rgb(1), two_sided));
        const TypeParam sampler(scene);
        const TriangleCorners t = world_triangle(scene, 1, 0);
        const vec3 normal = glm::normalize(glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]));
        const Frame frame(normal);
        const uint32_t sides = two_sided ? 2 : 1;
        expect_even(
            sampler, sides * kSide * kSide, 3,
            [&](const EmissionSample& sample) {
                const vec3 w = frame.to_local(sample.ray.direction);
                const uint32_t back = w.z < 0 ? 1 : 0;
                // Not on the wrong side, and started on the side it leaves to.
                EXPECT_EQ(back == 1, glm::dot(sample.ray.origin - t.p[0], normal) < 0);
                return square_cell(w.z * w.z, turn(w.y, w.x)) + back * kSide * kSide;
            },
            4);
        expect_even(
            sampler, kSide * kSide, 4,
            [&](const EmissionSample& sample) {
                // Barycentrics by areas; (1 - w0)^2 and v / (1 - w0) are even for even points.
                const vec3 p = sample.ray.origin;
                const double area = glm::dot(glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]), normal);
                const double w0 = glm::dot(glm::cross(t.p[1] - p, t.p[2] - p), normal) / area;
                const double v = glm::dot(glm::cross(t.p[1] - t.p[0], p - t.p[0]), normal) / area;
                return square_cell((1 - w0) * (1 - w0), v / (1 - w0));
            },
            4);
    }
}

TYPED_TEST_P(EmissionDirections, PointsShineEvenlyAndSpotsByTheirFalloff) {
    const Scene point = with_punctual(point_light(Rgb(1)));
    constexpr uint32_t kChecks = 6;
    expect_even(
        TypeParam(point), kSide * kSide, 5,
        [&](const EmissionSample& sample) {
            const vec3 w = sample.ray.direction;
            EXPECT_EQ(sample.ray.origin, point.punctual_lights[0].position);
            return square_cell(0.5 + 0.5 * w.z, turn(w.y, w.x));
        },
        kChecks);

    for (const auto& [inner, outer] : {std::pair{0.0f, 0.5f}, std::pair{0.3f, 0.8f}, std::pair{0.1f, 1.5f},
                                       std::pair{0.4f, 0.4f}, std::pair{0.03f, 0.03f}}) {
        const Scene scene = with_punctual(spot_light(inner, outer));
        const PunctualLight& light = scene.punctual_lights[0];
        const Frame frame(light.direction);
        const double o = light.cos_outer, width = std::max(0.001, double{light.cos_inner} - o);
        // Share of the flux between the rim and that cosine.
        const auto flux = [&](double cosine) {
            const double t = std::clamp((cosine - o) / width, 0.0, 1.0);
            return width * t * t * t / 3 + std::max(0.0, cosine - o - width);
        };
        expect_even(
            TypeParam(scene), kSide * kSide, 6,
            [&](const EmissionSample& sample) {
                const dvec3 w(frame.to_local(sample.ray.direction));
                // From the sine: the cosine of a narrow cone has few digits.
                const double cosine = std::sqrt(1 - std::min(1.0, w.x * w.x + w.y * w.y));
                return square_cell(flux(cosine) / flux(1), turn(w.y, w.x));
            },
            kChecks);
    }
}

/// Light from outside starts evenly on a disc that faces its direction, holds the scene and lies before it.
TYPED_TEST_P(EmissionDirections, LightFromOutsideStartsOnADiscBeforeTheScene) {
    const Scene sunny = with_punctual(sun()), cloudy = with_environment();
    for (const Scene* scene : {&sunny, &cloudy}) {
        const double radius = scene->bounds.radius();
        expect_even(
            TypeParam(*scene), kSide * kSide, 7,
            [&](const EmissionSample& sample) {
                const vec3 w = Frame(sample.ray.direction).to_local(sample.ray.origin - scene->bounds.centre());
                EXPECT_LT(w.z, -radius);
                EXPECT_GT(w.z, -1.1 * radius);
                return square_cell((w.x * w.x + w.y * w.y) / (radius * radius), turn(w.y, w.x));
            },
            2);
    }
}

TYPED_TEST_P(EmissionDirections, LightFromTheEnvironmentFollowsItsDensity) {
    const Scene scene = with_environment();
    const EnvironmentSampler density(*scene.environment);
    const TypeParam sampler(scene);
    constexpr uint32_t kSamples = 400000, kFine = 40, kRows = kSide * kFine;
    std::vector<double> observed(kSide * kSide), expected(kSide * kSide);
    const auto cell_of = [](const vec3& wi) { return square_cell(0.5 + 0.5 * wi.y, turn(wi.z, wi.x)); };
    for (uint32_t row = 0; row < kRows; ++row)
        for (uint32_t column = 0; column < kRows; ++column) {
            const double y = 2 * (row + 0.5) / kRows - 1, azimuth = 2 * kPiD * ((column + 0.5) / kRows - 0.5);
            const double r = std::sqrt(1 - y * y);
            const vec3 wi(dvec3(r * std::cos(azimuth), y, r * std::sin(azimuth)));
            expected[cell_of(wi)] += kSamples * double{density.pdf(wi)} * 4 * kPiD / (double{kRows} * kRows);
        }
    for (const auto& sample : draw_emission(sampler, kSamples, 8)) {
        ASSERT_TRUE(sample);
        ++observed[cell_of(-sample->ray.direction)];
    }
    EXPECT_GT(chi_square_probability(observed, expected), kEmissionFalseAlarm);
}

// --- agreement with direct light --------------------------------------------------------------------------------

/// Irradiance of the patch by photons that cross it from above, where nothing else is in their way.
template <class Emission>
RunningMean irradiance_by_photons(const Scene& scene, uint32_t samples) {
    RunningMean irradiance;
    for (const auto& sample : draw_emission(Emission(scene), samples, 9)) {
        double power_w = 0;
        if (sample && sample->ray.direction.y < 0 && sample->ray.origin.y > 0) {
            const float distance = -sample->ray.origin.y / sample->ray.direction.y;
            const vec3 p = sample->ray.origin + distance * sample->ray.direction;
            if (std::fabs(p.x) < kHalfPatch && std::fabs(p.z) < kHalfPatch)
                power_w = mean(sample->power_w) * range_window(distance, sample->range_m);
        }
        irradiance.add(power_w / (4 * kHalfPatch * kHalfPatch));
    }
    return irradiance;
}

/// The same by the sampler of direct light, from points spread over the patch.
inline RunningMean irradiance_by_light_sampling(const Scene& scene, uint32_t samples) {
    const LightSampler sampler(scene);
    RandomStream random(8, RandomDomain::Test, 0, 0);
    RunningMean irradiance;
    const vec3 n(0, 1, 0);
    for (uint32_t i = 0; i < samples; ++i) {
        const vec2 u = random.next_2d();
        const vec3 p(kHalfPatch * (2 * u.x - 1), 0, kHalfPatch * (2 * u.y - 1));
        const float u_select = random.next();
        LightSample sample;
        const bool lit = sampler.sample(p, n, u_select, random.next_2d(), sample) && sample.wi.y > 0;
        irradiance.add(lit ? double{mean(sample.radiance_over_pdf) * sample.wi.y} : 0.0);
    }
    return irradiance;
}

inline constexpr size_t kAgreementCases = 11;

/// Photons and direct light agree on the irradiance of a patch: the difference of two independent means.
template <class Emission>
void expect_agreement(const Scene& scene) {
    constexpr double kMustDetect = 0.03;
    const RunningMean photons = irradiance_by_photons<Emission>(scene, 1500000);
    const RunningMean direct = irradiance_by_light_sampling(scene, 1000000);
    const double z = two_sided_z(share_of_false_alarm(kEmissionFalseAlarm, kAgreementCases));
    const double tolerance = z * std::hypot(photons.standard_error(), direct.standard_error());
    EXPECT_GT(direct.mean(), 0);
    EXPECT_NEAR(photons.mean(), direct.mean(), tolerance);
    EXPECT_LT(tolerance, kMustDetect * direct.mean()) << "too noisy to notice a defect";
}

TYPED_TEST_P(EmissionAgreement, Triangle) { expect_agreement<TypeParam>(with_triangle(emitting(Rgb(3, 2, 1)))); }
TYPED_TEST_P(EmissionAgreement, TwoSidedTriangle) {
    expect_agreement<TypeParam>(with_triangle(emitting(Rgb(3, 2, 1), true)));
}
TYPED_TEST_P(EmissionAgreement, TwoSidedTriangleFromBehind) {
    expect_agreement<TypeParam>(with_triangle(emitting(Rgb(3, 2, 1), true), true));
}
TYPED_TEST_P(EmissionAgreement, TexturedTriangles) { expect_agreement<TypeParam>(with_textured_triangle()); }
TYPED_TEST_P(EmissionAgreement, Point) { expect_agreement<TypeParam>(with_punctual(point_light(Rgb(3, 2, 1)))); }
TYPED_TEST_P(EmissionAgreement, PointWithRange) {
    expect_agreement<TypeParam>(with_punctual(point_light(Rgb(3, 2, 1), 1.2f)));
}
TYPED_TEST_P(EmissionAgreement, Spot) { expect_agreement<TypeParam>(with_punctual(spot_light(0.2f, 0.7f))); }
TYPED_TEST_P(EmissionAgreement, SpotWithoutRamp) { expect_agreement<TypeParam>(with_punctual(spot_light(0.2f, 0.2f))); }
TYPED_TEST_P(EmissionAgreement, Directional) { expect_agreement<TypeParam>(with_punctual(sun())); }
TYPED_TEST_P(EmissionAgreement, Environment) { expect_agreement<TypeParam>(with_environment()); }
TYPED_TEST_P(EmissionAgreement, AllTogether) {
    Scene scene = with_environment();
    scene.punctual_lights = {sun(), point_light(Rgb(2)), spot_light(0.2f, 0.7f)};
    finish_scene(scene);
    expect_agreement<TypeParam>(scene);
}

REGISTER_TYPED_TEST_SUITE_P(EmissionFlux, Triangle, TexturedTriangles, PunctualLights, SpotsWithoutRamp, Environment,
                            ManyLightsOfAllKinds, DarkAndEmptyScenes);
REGISTER_TYPED_TEST_SUITE_P(EmissionDirections, TrianglesSendCosineDistributedLightFromEvenPlaces,
                            PointsShineEvenlyAndSpotsByTheirFalloff, LightFromOutsideStartsOnADiscBeforeTheScene,
                            LightFromTheEnvironmentFollowsItsDensity);
REGISTER_TYPED_TEST_SUITE_P(EmissionAgreement, Triangle, TwoSidedTriangle, TwoSidedTriangleFromBehind,
                            TexturedTriangles, Point, PointWithRange, Spot, SpotWithoutRamp, Directional, Environment,
                            AllTogether);

}  // namespace photond::test
