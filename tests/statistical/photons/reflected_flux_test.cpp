// The flux that reflected photons carry, against closed forms and against the photons that arrive from them. Chance of
// a false alarm 1e-6 for the file's checks together (Sidak); each says what relative error it must notice.

#include <gtest/gtest.h>

#include <functional>

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/transport/bsdf.h"
#include "tests/support/photons.h"
#include "tests/support/statistics.h"

namespace photond::reflected_flux_test {
namespace {

using test::photon_tracing;
using test::PhotonScene;
using test::power_after;
using Spread = ReflectedPhoton::Spread;

constexpr double kFalseAlarm = 1e-6;
constexpr size_t kChecks = 120;
constexpr size_t kReplicates = 24;

/// Independent estimates, one for each seed.
using Replicates = std::vector<double>;

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
    // Rounding: of float powers, and of what the tests themselves round.
    EXPECT_LE(std::abs(interval.mean), std::max(interval.half_width, 2e-6 * mean)) << "of " << mean;
    EXPECT_LE(2 * interval.half_width, must_detect * mean) << "too noisy to notice a defect";
}

template <class Estimate>
Replicates replicates(const Estimate& estimate) {
    return test::replicates(kReplicates, estimate);
}

PhotonTracing settings(uint32_t photons, uint32_t scatterings, PhotonInjection injection = PhotonInjection::Paths) {
    PhotonTracing tracing = photon_tracing(PhotonMapKind::Global, photons);
    tracing.most_scatterings = scatterings;
    tracing.injection = injection;
    return tracing;
}

/// Flux [W] that leaves after so many scatterings: of each photon what its direction, over its density, stands for.
double flux_leaving(
    const PhotonScene& lit, const TracedReflections& traced, uint32_t scatterings, float threshold,
    const std::function<double(const ReflectedPhoton&)>& weight = [](const auto&) { return 1.0; }) {
    double sum = 0;
    for (const ReflectedPhoton& photon : traced.photons) {
        if (photon.scatterings() != scatterings) continue;
        float flux_w = photon.power_w.x;
        if (photon.spread() == Spread::Lambert) flux_w *= photon.correction_towards(photon.direction);
        if (photon.spread() == Spread::Rough) {  // on flat surfaces, whose frames are about the geometric normal
            const ReflectingSurface& surface = traced.surfaces[photon.surface];
            const ShadingPoint point = make_shading_point(lit.scene, surface.hit, -surface.wi_world);
            const Bsdf rough = make_bsdf(lit.scene, point, surface.outside_ior).rough_part(threshold);
            const vec3 out = point.shading.to_local(photon.direction);
            const Rgb f_cos = rough.f_cos(point.shading.to_local(surface.wi_world), out, TransportMode::Importance);
            flux_w = surface.arriving_power_w.x * f_cos.x * kPi / out.z;
        }
        sum += double{flux_w} * weight(photon);
    }
    return sum;
}

/// A closed room from -1 to 1 of one material.
Scene room(const Material& material) {
    Scene scene;
    MeshBuilder walls;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            vec3 n(0), a(0), b(0);
            n[axis] = side, a[(axis + 1) % 3] = side, b[(axis + 2) % 3] = 1;
            walls.quad(n - a - b, n - a + b, n + a + b, n + a - b);  // faces inwards
        }
    add_mesh(scene, walls.build(add_material(scene, material)));
    PunctualLight point;
    point.position = {0.3f, -0.2f, 0.1f};
    scene.punctual_lights = {point};
    finish_scene(scene);
    return scene;
}
constexpr double kRoomFlux = 4 * double{kPi};  // of room()'s light [W]

// Whatever the room's shape, the s-th scattering leaves the light's flux times albedo^s.
TEST(ReflectedFlux, OfAClosedRoom) {
    constexpr float kAlbedo = 0.7f;
    const PhotonScene lit(room(lambert("wall", Rgb(kAlbedo))));
    for (const auto& [scatterings, must_detect] : {std::pair{1u, 0.05}, {2u, 0.08}, {4u, 0.3}})
        expect_same(must_detect, replicates([&](uint64_t seed) {
                        const TracedReflections left = lit.trace_reflected(settings(8'000, scatterings), seed);
                        return flux_leaving(lit, left, scatterings, 0.05f);
                    }),
                    {kRoomFlux * std::pow(double{kAlbedo}, scatterings)});
    expect_same(0.05, replicates([&](uint64_t seed) {
                    const PhotonTracing tracing = settings(8'000, 3, PhotonInjection::ReflectiveShadowMap);
                    return flux_leaving(lit, lit.trace_reflected(tracing, seed), 1, 0.05f);
                }),
                {kRoomFlux * double{kAlbedo}});
}

/// A room that leaves nothing out: its walls of that material, or a block of it in it where light passes it.
Scene closed_room_with(const Material& material) {
    Scene scene = room(lambert("wall", Rgb(0.8f)));
    const uint32_t index = add_material(scene, material);
    if (material.transmission > 0)
        add_mesh(scene, MeshBuilder().box({-0.9f, -0.9f, -0.9f}, {-0.2f, 0.1f, 0.2f}).build(index));
    else
        scene.meshes[0].material = index;
    finish_scene(scene);
    return scene;
}

// In a closed room all that leaves arrives. Coated walls, by Rough photons and Beams, whichever lobes are apart; rough
// metal; and rough glass, whose scattering is Beams throughout.
TEST(ReflectedFlux, IsWhatArrives) {
    Material frosted = glass("frosted");
    frosted.roughness = 0.4f;
    struct Case {
        Material material;
        float threshold;
        double must_detect;
        uint32_t scatterings = 2;
    };
    const Case cases[] = {{plastic("coated", Rgb(0.7f), 0.2f), 0.05f, 0.2},   // alpha 0.04: specular
                          {plastic("coated", Rgb(0.7f), 0.2f), 0.03f, 0.35},  // ... and rough
                          {metal("dark", Rgb(0.03f), 0.5f), 0.05f, 0.3, 1},   // kept more often than it reflects
                          {metal("brushed", Rgb(0.8f), 0.5f), 0.05f, 0.25},
                          {frosted, 0.05f, 0.2}};
    for (const auto& [material, threshold, must_detect, scatterings] : cases) {
        const PhotonScene lit(closed_room_with(material));
        PhotonTracing arriving = settings(8'000, 2);
        arriving.glossy_threshold = 0;  // all lobes that are no delta are rough: all that arrives is stored
        Replicates expected[2];
        for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
            const TracedPhotons traced = lit.trace(arriving, seed + 1000);
            for (uint32_t s : {1u, 2u}) expected[s - 1].push_back(power_after(traced, s).x);
        }
        for (const bool apart : {true, false}) {
            SCOPED_TRACE(material.name + (apart ? ", apart, " : ", beams, ") + std::to_string(threshold));
            PhotonTracing tracing = settings(8'000, 2);
            tracing.rough_apart = apart;
            tracing.glossy_threshold = threshold;
            Replicates left[2];
            for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
                const TracedReflections traced = lit.trace_reflected(tracing, seed);
                EXPECT_EQ(traced.surfaces.empty(), !apart || material.transmission > 0);
                for (uint32_t s : {1u, 2u}) left[s - 1].push_back(flux_leaving(lit, traced, s, threshold));
            }
            for (uint32_t s = 1; s <= scatterings; ++s) expect_same(must_detect, left[s - 1], expected[s - 1]);
        }
    }
}

/// A room with a ball whose shading normals lean far.
Scene room_with_ball() {
    Scene scene = room(lambert("wall", Rgb(0.6f)));
    const uint32_t ball = add_material(scene, lambert("ball", Rgb(0.9f)));
    add_mesh(scene, MeshBuilder().sphere({-0.2f, -0.3f, -0.3f}, 0.45f, 6).build(ball));
    finish_scene(scene);
    return scene;
}

/// Irradiance [W m^-2] at x by all photons after one scattering, by next event estimation from their places: what
/// splats that connect do.
double irradiance_at(const PhotonScene& lit, const TracedReflections& traced, const vec3& x, const vec3& normal,
                     const vec3& half) {
    // Averaged over a patch, so that it can be compared with photons that arrive there: one place for each photon.
    double sum = 0;
    RandomStream random(1, RandomDomain::Test, 0, traced.photons.size());
    for (const ReflectedPhoton& photon : traced.photons) {
        const vec2 u = random.next_2d();
        const vec3 other = glm::cross(normal, half);
        const vec3 place = x + (2 * u.x - 1) * half + (2 * u.y - 1) * other;
        const vec3 way = place - photon.position;
        const float distance = glm::length(way);
        const vec3 w = way / distance;
        const float cos_y = glm::dot(photon.normal, w), cos_x = -glm::dot(normal, w);
        if (cos_y <= 0 || cos_x <= 0) continue;
        const vec3 start = offset_ray_origin(photon.position, photon.normal);
        if (lit.intersector->occluded({start, w, distance * (1 - 1e-4f)})) continue;
        sum += double{photon.power_w.x * photon.correction_towards(w) * cos_y * cos_x / (kPi * sqr(distance))};
    }
    return sum;
}

// Shading normals: what the records say of the light's directions is what the paths do, along the photons' own
// directions and towards places that are given; also where light comes from below the smooth normal's plane.
TEST(ReflectedFlux, FollowsShadingNormals) {
    const PhotonScene lit(room_with_ball());
    // A patch of the floor that the ball is near to.
    const vec3 x(-0.2f, -1, -0.3f), normal(0, 1, 0), half(0.3f, 0, 0);
    const auto on_patch = [&](const Photon& photon) {
        const vec3 d = glm::abs(photon.position - x);
        return photon.payload.scatterings() == 1 && d.y < 1e-3f && d.x <= half.x && d.z <= half.x;
    };
    Replicates arrived[2], on_floor;
    for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
        const TracedPhotons traced = lit.trace(settings(80'000, 2), seed + 1000);
        for (uint32_t s : {1u, 2u}) arrived[s - 1].push_back(power_after(traced, s).x);
        on_floor.push_back(test::power_of(traced, on_patch).x / (4 * sqr(half.x)));
    }
    // All of the flux that leaves arrives somewhere: the room is closed.
    Replicates left[2];
    for (uint64_t seed = 1; seed <= kReplicates; ++seed) {
        const TracedReflections traced = lit.trace_reflected(settings(20'000, 2), seed);
        for (uint32_t s : {1u, 2u}) left[s - 1].push_back(flux_leaving(lit, traced, s, 0.05f));
    }
    for (const int i : {0, 1}) expect_same(0.05, left[i], arrived[i]);
    for (const PhotonInjection injection : {PhotonInjection::Paths, PhotonInjection::ReflectiveShadowMap})
        expect_same(0.15, replicates([&](uint64_t seed) {
                        const TracedReflections traced = lit.trace_reflected(settings(20'000, 1, injection), seed);
                        return irradiance_at(lit, traced, x, normal, half);
                    }),
                    on_floor);
}

// What arrives after one scattering, times the reflectance at its place, is what leaves after two.
TEST(ReflectedFlux, OfTheSecondScattering) {
    const PhotonScene lit(make_builtin_scene("cornell-box"));
    const auto reflected = [&](uint64_t seed) {
        double sum = 0;
        const TracedPhotons traced = lit.trace(settings(8'000, 1), seed);
        for (const Photon& photon : traced.photons) {
            // Back along the way it came, to look up what it met.
            const vec3 wi = photon.payload.wi_world();
            const Ray back{photon.position + 1e-2f * wi, -wi, 2e-2f};
            const Hit hit = lit.intersector->closest_hit(back);
            if (!hit.valid()) continue;
            const ShadingPoint point = make_shading_point(lit.scene, hit, -wi);
            sum += double{photon.payload.power_w.x * lit.scene.materials[point.material].base_color.x};
        }
        return sum;
    };
    expect_same(0.1, replicates([&](uint64_t seed) {
                    return flux_leaving(lit, lit.trace_reflected(settings(8'000, 2), seed), 2, 0.05f);
                }),
                replicates([&](uint64_t seed) { return reflected(seed + 1000); }));
}

/// The Cornell box's lamp, a sun, a sky, a window of range, and a lot of weak lights.
Scene many_lights() {
    Scene scene = make_builtin_scene("cornell-box");
    PunctualLight sun;
    sun.kind = PunctualLight::Kind::Directional;
    sun.direction = glm::normalize(vec3(0.3f, -0.5f, -1));
    sun.intensity = Rgb(2);
    PunctualLight spot;
    spot.kind = PunctualLight::Kind::Spot;
    spot.position = scene.bounds.centre();
    spot.direction = {0, -1, 0};
    spot.cos_outer = 0.6f;
    spot.cos_inner = 0.8f;
    spot.range_m = scene.bounds.radius();
    scene.punctual_lights = {sun, spot};
    for (int i = 0; i < 300; ++i) {
        PunctualLight weak;
        weak.position = scene.bounds.centre() + 0.1f * scene.bounds.radius() * vec3(std::sin(i), std::cos(i), 0.5f);
        weak.intensity = Rgb(0.02f);
        scene.punctual_lights.push_back(weak);
    }
    Environment sky;
    sky.map.size = {8, 4};
    sky.map.radiance.assign(32, Rgb(0.2f));
    scene.environment = sky;
    finish_scene(scene);
    return scene;
}

// Both ways to start see the same light, and in the same places.
TEST(ReflectedFlux, DoesNotDependOnTheInjection) {
    for (const bool many : {false, true}) {
        const PhotonScene lit(many ? many_lights() : make_builtin_scene("cornell-box-glass"));
        const vec3 centre = lit.scene.bounds.centre();
        const auto high = [&](const ReflectedPhoton& p) { return p.position.y > centre.y ? 1.0 : 0.0; };
        const auto left = [&](const ReflectedPhoton& p) { return p.position.x < centre.x ? 1.0 : 0.0; };
        const auto all = [](const ReflectedPhoton&) { return 1.0; };
        const std::function<double(const ReflectedPhoton&)> weights[] = {all, high, left};
        for (const auto& weight : weights) {
            const auto flux = [&](PhotonInjection injection, uint64_t first_seed) {
                return replicates([&](uint64_t seed) {
                    const PhotonTracing tracing = settings(8'000, 1, injection);
                    return flux_leaving(lit, lit.trace_reflected(tracing, first_seed + seed), 1, 0.05f, weight);
                });
            };
            expect_same(0.1, flux(PhotonInjection::ReflectiveShadowMap, 0), flux(PhotonInjection::Paths, 1000));
        }
    }
}

}  // namespace
}  // namespace photond::reflected_flux_test
