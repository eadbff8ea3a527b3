// The power that photons carry, against closed forms: rooms whose walls reflect a known share, mirrors, glass, all
// kinds of lights. Chance of a false alarm 1e-6 for the file's checks together (Sidak); each test says what relative
// error it must notice.

#include <gtest/gtest.h>

#include "renderer/photons/photon_guides.h"
#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/photons.h"
#include "tests/support/statistics.h"

namespace photond::photon_flux_test {
namespace {

using test::photon_tracing;
using test::PhotonScene;
using test::power_after;
using test::power_of;

constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 200;
constexpr size_t kReplicates = 24;

const auto kAny = [](const Photon&) { return true; };

/// Each component of `measure(seed)` must have the mean `exact`, and vary so little that `must_detect` (relative) would
/// be noticed.
template <class Measure>
void expect_mean(const dvec3& exact, double must_detect, const Measure& measure) {
    std::vector<double> values[3];
    for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
        const dvec3 value = measure(seed);
        for (int c = 0; c < 3; ++c) values[c].push_back(value[c]);
    }
    for (int c = 0; c < 3; ++c) {
        const test::Interval measured = test::mean_interval(values[c], kFalseAlarm, kChecks);
        // Rounding: of float powers, and of what the tests themselves round.
        EXPECT_LE(std::abs(measured.mean - exact[c]), std::max(measured.half_width, 2e-6 * exact[c]))
            << "channel " << c << ": measured " << measured.mean << ", exact " << exact[c];
        EXPECT_LE(2 * measured.half_width, must_detect * exact[c]) << "too noisy to notice a defect, channel " << c;
    }
}

/// A closed room from -1 to 1, seen from inside, whose walls reflect that share.
Scene room(const Rgb& albedo) {
    Scene scene;
    MeshBuilder walls;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            vec3 n(0), a(0), b(0);
            n[axis] = side, a[(axis + 1) % 3] = side, b[(axis + 2) % 3] = 1;
            walls.quad(n - a - b, n - a + b, n + a + b, n + a - b);  // faces inwards
        }
    add_mesh(scene, walls.build(add_material(scene, lambert("wall", albedo))));
    return scene;
}

PunctualLight point_light(const vec3& position, const Rgb& intensity = Rgb(1)) {
    PunctualLight light;
    light.position = position;
    light.intensity = intensity;
    return light;
}

// Photons arrive after s scatterings with the light's flux times albedo^s, whatever the room's shape.
void expect_powers_of(const Rgb& albedo, const dvec3& flux_w, const PhotonScene& lit, SamplerKind sampler) {
    PhotonTracing tracing = photon_tracing(PhotonMapKind::Global, 8'000);
    tracing.sampler = sampler;
    const std::pair<uint32_t, double> orders[] = {{1, 0.05}, {2, 0.08}, {3, 0.12}, {6, 0.6}};
    for (const auto& [scatterings, must_detect] : orders) {
        SCOPED_TRACE(scatterings);
        tracing.most_scatterings = scatterings;
        expect_mean(flux_w * glm::pow(dvec3(albedo), dvec3(scatterings)), must_detect,
                    [&](uint64_t seed) { return power_after(lit.trace(tracing, seed), scatterings); });
    }
}

TEST(PhotonFlux, OfAPointLightInAClosedRoom) {
    const Rgb albedo(0.9f, 0.7f, 0.5f), intensity(1, 2, 3);
    Scene scene = room(albedo);
    scene.punctual_lights = {point_light({0.3f, -0.2f, 0.1f}, intensity)};
    finish_scene(scene);
    const PhotonScene lit(std::move(scene));
    for (const SamplerKind sampler : {SamplerKind::Sobol, SamplerKind::Random})
        expect_powers_of(albedo, 4 * double{kPi} * dvec3(intensity), lit, sampler);
}

TEST(PhotonFlux, OfALampInAClosedRoom) {
    const Rgb albedo(0.8f);
    Scene scene = room(albedo);
    Material lamp = lambert("lamp", albedo);  // reflects like the walls, from both sides
    lamp.emission = Rgb(5, 4, 3);
    add_mesh(scene, MeshBuilder()
                        .quad({-0.2f, 0.9f, -0.3f}, {0.2f, 0.9f, -0.3f}, {0.2f, 0.9f, 0.3f}, {-0.2f, 0.9f, 0.3f})
                        .build(add_material(scene, lamp)));
    finish_scene(scene);
    expect_powers_of(albedo, dvec3(5, 4, 3) * (double{kPi} * 0.24), PhotonScene(std::move(scene)), SamplerKind::Sobol);
}

// A coated wall scatters by both of its parts, or, below the threshold, by one. What caustic photons carry is the rest
// of the global ones' power, at each order; with all lobes rough everything is in the global map.
TEST(PhotonFlux, DoesNotDependOnTheSplitIntoParts) {
    Scene scene = room(Rgb(0.7f));
    scene.materials[0] = plastic("coated", Rgb(0.7f), 0.2f);  // alpha 0.04
    scene.punctual_lights = {point_light({0.3f, -0.2f, 0.1f})};
    finish_scene(scene);
    const PhotonScene lit(std::move(scene));
    PhotonTracing split = photon_tracing(PhotonMapKind::Global, 8'000), caustic = split, whole = split;
    caustic.kind = PhotonMapKind::Caustic;
    split.most_scatterings = caustic.most_scatterings = whole.most_scatterings = 2;
    whole.glossy_threshold = 0.03f;
    for (const uint32_t scatterings : {1u, 2u}) {
        std::vector<double> difference;
        double mean = 0;
        for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
            const double a = (power_after(lit.trace(split, seed), scatterings) +
                              power_after(lit.trace(caustic, seed + 1000), scatterings))
                                 .x;
            const double b = power_after(lit.trace(whole, seed + 2000), scatterings).x;
            difference.push_back(a - b);
            mean += b / kReplicates;
        }
        const test::Interval interval = test::mean_interval(difference, kFalseAlarm, kChecks);
        EXPECT_LE(std::abs(interval.mean), interval.half_width) << scatterings;
        EXPECT_LE(2 * interval.half_width, 0.1 * mean) << scatterings;
        EXPECT_GT(mean, 0.5 * 4 * double{kPi} * std::pow(0.6, scatterings));
    }
}

// KHR_lights_punctual's window over a cube's faces, by midpoint quadrature.
TEST(PhotonFlux, FollowsALightsRange) {
    constexpr float kRange = 1.4f;
    Scene scene = room(Rgb(0.5f));
    scene.punctual_lights = {point_light(vec3(0))};
    scene.punctual_lights[0].range_m = kRange;
    finish_scene(scene);
    const PhotonScene lit(std::move(scene));
    constexpr int kSteps = 400;
    double flux = 0;
    for (int i = 0; i < kSteps; ++i)
        for (int k = 0; k < kSteps; ++k) {
            const double x = (i + 0.5) / kSteps, y = (k + 0.5) / kSteps, d_sq = 1 + x * x + y * y;
            const double window = std::max(0.0, 1 - d_sq * d_sq / std::pow(double{kRange}, 4));
            flux += 24 * window * std::pow(d_sq, -1.5) / (double{kSteps} * kSteps);
        }
    PhotonTracing tracing = photon_tracing(PhotonMapKind::Global, 8'000);
    tracing.most_scatterings = 1;
    expect_mean(dvec3(0.5 * flux), 0.05, [&](uint64_t seed) { return power_of(lit.trace(tracing, seed), kAny); });
}

/// A floor of one metre by one, and an ideal mirror that stands upright on its edge z = 0 and faces +z.
Scene floor_and_mirror() {
    Scene scene;
    add_mesh(scene, MeshBuilder()
                        .quad({0, 0, 1}, {1, 0, 1}, {1, 0, 0}, {0, 0, 0})
                        .build(add_material(scene, lambert("floor", Rgb(0.5f)))));
    add_mesh(scene, MeshBuilder()
                        .quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0})
                        .build(add_material(scene, metal("mirror", Rgb(1), 0))));
    return scene;
}

TEST(PhotonFlux, OfADirectionalLightOffAMirror) {
    Scene scene = floor_and_mirror();
    PunctualLight sun;
    sun.kind = PunctualLight::Kind::Directional;
    sun.intensity = {1, 2, 3};
    sun.direction = glm::normalize(vec3(0, -1, -1));
    scene.punctual_lights = {sun};
    finish_scene(scene);
    const PhotonScene lit(std::move(scene));
    const PhotonTracing tracing = photon_tracing(PhotonMapKind::Caustic, 8'000);
    // What the mirror meets comes down at its own height's distance: irradiance cos 45 degrees, evenly.
    const dvec3 exact = dvec3(1, 2, 3) * std::sqrt(0.5);
    expect_mean(exact, 0.08, [&](uint64_t seed) { return power_of(lit.trace(tracing, seed), kAny); });
    expect_mean(0.25 * exact, 0.2, [&](uint64_t seed) {
        return power_of(lit.trace(tracing, seed), [](const Photon& p) { return p.position.z < 0.25f; });
    });
}

// Reflected light from everywhere: pi L A F, F the form factor of two squares that share an edge at a right angle,
// 0.20004 (Howell's catalogue, C-14).
TEST(PhotonFlux, OfAnEnvironmentOffAMirror) {
    Scene scene = floor_and_mirror();
    Environment sky;
    sky.map.size = {8, 4};
    sky.map.radiance.assign(32, Rgb(1, 2, 3));
    scene.environment = sky;
    finish_scene(scene);
    const PhotonScene lit(std::move(scene));
    const double form_factor =
        (2 * std::atan(1.0) - std::sqrt(2.0) * std::atan(std::sqrt(0.5)) + 0.25 * std::log(4.0 / 3 * 9.0 / 16)) /
        double{kPi};
    ASSERT_NEAR(form_factor, 0.20004, 1e-4);
    const PhotonTracing tracing = photon_tracing(PhotonMapKind::Caustic, 20'000);
    expect_mean(dvec3(1, 2, 3) * (double{kPi} * form_factor), 0.2,
                [&](uint64_t seed) { return power_of(lit.trace(tracing, seed), kAny); });
}

// Light straight down through a slab: (1 - R)^2 a / (1 - R^2 a^2) of it, R = ((n - 1)/(n + 1))^2 at each face, a what
// the glass leaves of it on one crossing.
TEST(PhotonFlux, ThroughAGlassSlab) {
    Scene scene;
    add_mesh(scene, MeshBuilder()
                        .quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1})
                        .build(add_material(scene, lambert("floor", Rgb(0.5f)))));
    Material tinted = glass("slab");
    tinted.attenuation_color = {0.9f, 0.5f, 0.25f};
    tinted.attenuation_distance = 0.5f;  // the slab's thickness
    add_mesh(scene, MeshBuilder().box({-0.5f, 0.5f, -0.5f}, {0.5f, 1, 0.5f}).build(add_material(scene, tinted)));
    PunctualLight sun;
    sun.kind = PunctualLight::Kind::Directional;
    sun.direction = {0, -1, 0};
    scene.punctual_lights = {sun};
    finish_scene(scene);
    const PhotonScene lit(std::move(scene));
    const dvec3 a(0.9, 0.5, 0.25);
    constexpr double kR = 0.04;
    const dvec3 exact = (1 - kR) * (1 - kR) * a / (1.0 - kR * kR * a * a);
    const PhotonTracing tracing = photon_tracing(PhotonMapKind::Caustic, 8'000);
    expect_mean(exact, 0.1, [&](uint64_t seed) { return power_of(lit.trace(tracing, seed), kAny); });
}

// Clear glass absorbs nothing: all of the light inside of a glass ball comes out.
TEST(PhotonFlux, OutOfAGlassBall) {
    Scene scene = room(Rgb(0.5f));
    Mesh ball = make_icosphere(4, add_material(scene, glass("ball")));
    ball.normals.clear();
    for (vec3& p : ball.positions) p *= 0.5f;
    add_mesh(scene, std::move(ball));
    scene.punctual_lights = {point_light({0.02f, 0.01f, -0.03f})};
    finish_scene(scene);
    const PhotonScene lit(std::move(scene));
    const PhotonTracing tracing = photon_tracing(PhotonMapKind::Caustic, 8'000);
    expect_mean(dvec3(4 * double{kPi}), 0.03, [&](uint64_t seed) { return power_of(lit.trace(tracing, seed), kAny); });
}

// As many photons of the same power, whether the guide leads them or not.
void expect_the_guide_changes_no_power(Scene scene, PhotonMapKind kind, uint32_t photons) {
    const PhotonScene lit(std::move(scene));
    PhotonTracing tracing = photon_tracing(kind, photons), guided = tracing;
    const ProjectionMap guide(lit.scene, *lit.intersector, lit.emission, target_of(kind), tracing.glossy_threshold, 1);
    ASSERT_TRUE(guide.helps());
    guided.guide = &guide;
    std::vector<double> difference;
    double mean = 0;
    uint64_t stored = 0, stored_guided = 0;
    for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
        const TracedPhotons a = lit.trace(tracing, seed), b = lit.trace(guided, seed + 1000);
        stored += a.photons.size(), stored_guided += b.photons.size();
        difference.push_back(power_of(a, kAny).x - power_of(b, kAny).x);
        mean += power_of(a, kAny).x / kReplicates;
    }
    const test::Interval interval = test::mean_interval(difference, kFalseAlarm, kChecks);
    EXPECT_LE(std::abs(interval.mean), interval.half_width);
    EXPECT_LE(2 * interval.half_width, 0.1 * mean);
    EXPECT_GT(stored_guided, stored);
}

TEST(PhotonFlux, OfCausticPhotonsDoesNotDependOnTheGuide) {
    expect_the_guide_changes_no_power(make_builtin_scene("cornell-box-glass"), PhotonMapKind::Caustic, 20'000);
}

// A yard of two walls below a low sun, whose light goes past it for the most part.
TEST(PhotonFlux, OfGlobalPhotonsDoesNotDependOnTheGuide) {
    Scene scene;
    add_mesh(scene, MeshBuilder()
                        .quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2})
                        .quad({1, 0, -1}, {1, 0, 1}, {1, 0.6f, 1}, {1, 0.6f, -1})
                        .build(add_material(scene, lambert("yard", Rgb(0.6f)))));
    PunctualLight sun;
    sun.kind = PunctualLight::Kind::Directional;
    sun.intensity = Rgb(3, 2, 1);
    sun.direction = glm::normalize(vec3(1, -0.3f, 0.2f));
    scene.punctual_lights = {sun};
    finish_scene(scene);
    expect_the_guide_changes_no_power(std::move(scene), PhotonMapKind::Global, 60'000);
}

}  // namespace
}  // namespace photond::photon_flux_test
