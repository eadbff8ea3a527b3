// The flux that virtual lights have, against that of all reflected photons (PhotonTracer::trace_reflected(), which
// reflected_flux_test holds to closed forms) and against closed forms. Chance of a false alarm 1e-6 for the file's
// checks together (Sidak); each says what relative error it must notice.

#include <gtest/gtest.h>

#include <functional>

#include "renderer/many_lights/vpl_tracer.h"
#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "tests/support/photons.h"
#include "tests/support/statistics.h"

namespace photond::vpl_flux_test {
namespace {

using test::PhotonScene;
using Spread = ReflectedPhoton::Spread;

constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 120;
constexpr size_t kReplicates = 24;

/// Independent estimates, one for each seed.
using Replicates = std::vector<double>;
using Weight = std::function<double(const ReflectedPhoton&)>;

/// Both must have the same mean, and vary so little that `must_detect` of it would be noticed. One value: exact.
void expect_same(double must_detect, const Replicates& measured, const Replicates& expected) {
    Replicates differences;
    double mean = 0;
    for (size_t i = 0; i < measured.size(); ++i) {
        const double other = expected[std::min(i, expected.size() - 1)];
        differences.push_back(measured[i] - other);
        mean += other / static_cast<double>(measured.size());
    }
    ASSERT_GT(mean, 0);
    const test::Interval interval = test::mean_interval(differences, kFalseAlarm, kChecks);
    EXPECT_LE(std::abs(interval.mean), std::max(interval.half_width, 2e-6 * mean)) << "of " << mean;
    EXPECT_LE(2 * interval.half_width, must_detect * mean) << "too noisy to notice a defect";
}

VplTracing settings(uint32_t vpls, uint32_t bounces, uint32_t map_side = 32) {
    return {.vpls = vpls, .map_side = map_side, .bounces = bounces};
}

TracedReflections trace(const PhotonScene& lit, const VplTracing& tracing, uint64_t seed,
                        const TexelImportance& importance = {}) {
    Stats stats;
    return VplTracer(lit.scene, *lit.intersector, *lit.intersector, lit.emission, tracing)
        .trace(seed, 0, importance, stats, CancelToken{});
}

/// Mean over the channels of the power that leaves after so many scatterings, beams not counted.
double flux(const TracedReflections& traced, uint32_t scatterings, const Weight& weight) {
    double sum = 0;
    for (const ReflectedPhoton& photon : traced.photons)
        if (photon.scatterings() == scatterings && photon.spread() != Spread::Beam)
            sum += double{mean(photon.power_w)} * weight(photon);
    return sum;
}
double plain(const ReflectedPhoton&) { return 1; }

/// The lights' flux after each scattering, and that within a part of the scene, must be the photons'.
void expect_the_photons_flux(const Scene& scene, uint32_t bounces, double must_detect,
                             const TexelImportance& importance = {}) {
    const PhotonScene lit(scene);
    const vec3 centre = lit.scene.bounds.centre();
    const Weight in_part = [=](const ReflectedPhoton& p) {
        return p.position.x + 0.5f * p.position.y < centre.x + 0.5f * centre.y ? 1.0 : 0.1;
    };
    PhotonTracing photons = test::photon_tracing(PhotonMapKind::Global, 20'000);
    photons.most_scatterings = bounces;
    photons.glossy_threshold = VplTracing{}.connect_threshold;
    std::vector<TracedReflections> all, vpls;
    for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
        all.push_back(lit.trace_reflected(photons, seed + 1000));
        vpls.push_back(trace(lit, settings(1'000, bounces), seed, importance));
    }
    for (uint32_t s = 1; s <= bounces; ++s)
        for (const Weight& weight : {Weight(plain), in_part}) {
            SCOPED_TRACE(s);
            Replicates measured, expected;
            for (size_t i = 0; i < kReplicates; ++i) {
                measured.push_back(flux(vpls[i], s, weight));
                expected.push_back(flux(all[i], s, weight));
            }
            expect_same(s * must_detect, measured, expected);
        }
}

// Area lights and a spot; glossy and glass surfaces; all kinds of lights together.
TEST(VplFlux, IsThePhotons) {
    for (const char* name :
         {"cornell-box", "cornell-box-spot", "cornell-box-glossy", "cornell-box-glass", "interior"}) {
        SCOPED_TRACE(name);
        expect_the_photons_flux(make_builtin_scene(name), 3, 0.15);
    }
}

/// A floor and a wall with a ball, its shading normals leaning far, for any light.
Scene open_scene() {
    Scene scene;
    add_mesh(scene, MeshBuilder()
                        .quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2})
                        .quad({-2, 0, -2}, {2, 0, -2}, {2, 3, -2}, {-2, 3, -2})
                        .build(add_material(scene, lambert("floor", Rgb(0.7f, 0.4f, 0.2f)))));
    add_mesh(scene,
             MeshBuilder().sphere({0.4f, 0.6f, 0}, 0.5f, 8).build(add_material(scene, lambert("ball", Rgb(0.8f)))));
    return scene;
}

TEST(VplFlux, OfEachKindOfPunctualLightAndTheSky) {
    for (const auto kind : {PunctualLight::Kind::Point, PunctualLight::Kind::Spot, PunctualLight::Kind::Directional}) {
        SCOPED_TRACE(static_cast<int>(kind));
        Scene scene = open_scene();
        PunctualLight light;
        light.kind = kind;
        light.position = {0.5f, 2, 1};
        light.direction = glm::normalize(vec3(-0.2f, -1, -0.5f));
        light.intensity = Rgb(1, 2, 3);
        light.range_m = 5;
        scene.punctual_lights = {light};
        finish_scene(scene);
        expect_the_photons_flux(scene, 2, 0.3);
    }
    Scene sky = open_scene();
    Environment environment;
    environment.map.size = {8, 4};
    for (uint32_t i = 0; i < 32; ++i) environment.map.radiance.push_back(Rgb(0.2f + 0.3f * static_cast<float>(i % 5)));
    sky.environment = environment;
    finish_scene(sky);
    expect_the_photons_flux(sky, 2, 0.4);
}

// Chosen by more than flux: powers change, the mean does not.
TEST(VplFlux, WithAnImportanceIsTheSame) {
    expect_the_photons_flux(make_builtin_scene("cornell-box"), 2, 0.2, [](const ReflectedPhoton& photon) {
        return photon.position.y < 0.3f ? 0.0f : 10 * photon.position.x * photon.position.x;
    });
}

/// A closed room from -1 to 1 with many point lights: the first red, the others green.
Scene room(float albedo, uint32_t lights, float first) {
    Scene scene;
    MeshBuilder walls;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            vec3 n(0), a(0), b(0);
            n[axis] = side, a[(axis + 1) % 3] = side, b[(axis + 2) % 3] = 1;
            walls.quad(n - a - b, n - a + b, n + a + b, n + a - b);
        }
    add_mesh(scene, walls.build(add_material(scene, lambert("wall", Rgb(albedo)))));
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (uint32_t i = 0; i < lights; ++i) {
        PunctualLight point;
        const vec2 u = random.next_2d();
        point.position = 1.6f * vec3(u.x - 0.5f, u.y - 0.5f, random.next() - 0.5f);
        point.intensity = i == 0 ? Rgb(first, 0, 0) : Rgb(0, 1, 0);
        scene.punctual_lights.push_back(point);
    }
    finish_scene(scene);
    return scene;
}

// One light among many gives what it should, strong or weak, and all together: in a closed room flux times albedo^s.
TEST(VplFlux, OfOneLightAmongManyIsItsOwn) {
    struct Case {
        uint32_t lights, map_side;
        float first;
        double must_detect;  // of the first's flux
    };
    for (const auto& [lights, side, first, must_detect] :
         {Case{3, 32, 1, 0.05}, {40, 16, 2, 0.3}, {500, 16, 20, 0.3}, {10'000, 64, 300, 0.2}, {10'000, 16, 500, 0.5}}) {
        SCOPED_TRACE(std::to_string(lights) + " lights");
        const PhotonScene lit(room(0.5f, lights, first));
        Replicates red, green[2];
        for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
            const TracedReflections traced = trace(lit, settings(1'000, 2, side), seed);
            double sums[2] = {};
            double of_first = 0;
            for (const ReflectedPhoton& photon : traced.photons) {
                sums[photon.scatterings() - 1] += double{photon.power_w.y};
                if (photon.scatterings() == 1) of_first += double{photon.power_w.x};
            }
            red.push_back(of_first);
            for (int s = 0; s < 2; ++s) green[s].push_back(sums[s]);
        }
        constexpr double kSphere = 4 * double{kPi};
        expect_same(must_detect, red, {kSphere * 0.5 * double{first}});
        expect_same(0.05, green[0], {kSphere * 0.5 * (lights - 1)});
        expect_same(0.1, green[1], {kSphere * 0.25 * (lights - 1)});
    }
}

}  // namespace
}  // namespace photond::vpl_flux_test
