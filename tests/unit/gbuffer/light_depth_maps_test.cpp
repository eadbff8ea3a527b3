// Shadow maps of lights: planes at any incidence, seams of cubes, the filter's mean, and shadow rays as the oracle.

#include "renderer/gbuffer/light_depth_maps.h"

#include <gtest/gtest.h>

#include <cstring>

#include "protocol/error.h"
#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/transport/light_sampling.h"
#include "tests/support/lit_rooms.h"
#include "tests/support/threads.h"

namespace photond::light_depth_maps_test {
namespace {

/// A scene with its maps.
class Lit {
public:
    explicit Lit(Scene scene) : scene_(std::move(scene)) {
        MemoryBudget budget;
        Stats stats;
        intersector_ = make_embree_intersector(scene_, budget, stats);
    }
    LightDepthMaps trace(uint32_t resolution, uint32_t pcf) const {
        Stats stats;
        LightDepthMaps maps(scene_, *intersector_, resolution, pcf, stats);
        EXPECT_EQ(stats.counts.shadow_rays, maps.depths_m().size());
        EXPECT_EQ(maps.bytes(), LightDepthMaps::bytes_for(scene_, resolution));
        EXPECT_EQ(stats.stages.at(0).name, "shadow_maps");
        return maps;
    }
    bool lit(const LightDepthMaps& maps, const test::FacingPoint& point, const vec2& u) const {
        const LightSeen seen =
            maps.seen(light_source_of_punctual(scene_, point.light), point.position, point.normal, u);
        EXPECT_NE(seen, LightSeen::Unknown);
        return seen == LightSeen::Whole;
    }
    const Scene& scene() const { return scene_; }
    const Intersector& intersector() const { return *intersector_; }

private:
    Scene scene_;
    std::unique_ptr<Intersector> intersector_;
};

vec3 unit_vector(RandomStream& random) {
    const float z = 2 * random.next() - 1, phi = 2 * kPi * random.next(), r = std::sqrt(std::max(0.0f, 1 - z * z));
    return {r * std::cos(phi), r * std::sin(phi), z};
}

/// A texel's width at the point's distance, at most: half diagonals of its square included.
float reach_m(const Scene& scene, const test::FacingPoint& point, uint32_t resolution, float texels) {
    const PunctualLight& light = scene.punctual_lights[point.light];
    const float across = texels / static_cast<float>(resolution);
    if (light.kind == PunctualLight::Kind::Directional) return across * 2 * scene.bounds.radius();
    return across * 2 * glm::length(light.position - point.position);
}

/// Whether shadow rays to places within `reach` of the light's direction, on the point's tangent plane, all say what
/// the point's own says: no shadow's edge and no step of the surface is near.
bool far_from_edges(const Lit& room, const test::FacingPoint& point, float reach, RandomStream& random) {
    const PunctualLight& light = room.scene().punctual_lights[point.light];
    const Ray own = test::towards(light, point.position);
    const bool lit = test::lit_by_ray(room.scene(), room.intersector(), point);
    const Frame frame(own.direction);
    for (int i = 0; i < 64; ++i) {
        const float r = 1.5f * reach * std::sqrt(random.next()), phi = 2 * kPi * random.next();
        const vec3 aside = r * (std::cos(phi) * frame.tangent + std::sin(phi) * frame.bitangent);
        // From the light along a ray beside the point's, to a texel's width before the plane.
        const bool parallel = light.kind == PunctualLight::Kind::Directional;
        const float back = 2 * room.scene().bounds.radius();
        const vec3 start = parallel ? point.position + aside + back * own.direction : light.position;
        const vec3 direction = parallel ? -own.direction : glm::normalize(point.position + aside - light.position);
        const float plane = glm::dot(point.position - start, point.normal) / glm::dot(direction, point.normal);
        if (!(plane > 0)) return false;  // over the plane's horizon
        if (room.intersector().occluded({start, direction, plane - reach}) == lit) return false;
        if (!lit && !room.intersector().occluded({start, direction, plane - 3 * reach})) return false;  // a contact
    }
    return true;
}

TEST(LightDepthMaps, AreShadowRaysButNearEdgesWhichTheResolutionNarrows) {
    const Lit room(test::lit_room());
    const std::vector<test::FacingPoint> points =
        test::facing_points(room.scene(), room.intersector(), 20000, 0.05f, 1);
    ASSERT_GT(points.size(), 5000u);
    for (const uint32_t pcf : {0u, 3u}) {
        double before = 1;
        for (const uint32_t resolution : {64u, 256u, 1024u}) {
            const LightDepthMaps maps = room.trace(resolution, pcf);
            RandomStream random(resolution, RandomDomain::Test, 1, 0);
            size_t wrong = 0, far = 0, far_wrong = 0;
            for (const test::FacingPoint& point : points) {
                const bool is_wrong = room.lit(maps, point, random.next_2d()) !=
                                      test::lit_by_ray(room.scene(), room.intersector(), point);
                wrong += is_wrong ? 1 : 0;
                // Half the filter's diagonal, and a texel and a half.
                const float reach = reach_m(room.scene(), point, resolution, 0.71f * float(pcf) + 1.5f);
                if (!far_from_edges(room, point, reach, random)) continue;
                ++far, far_wrong += is_wrong ? 1 : 0;
            }
            // Sixty-four rays may miss what is thin. Without tolerance, or with another plane, whole surfaces are
            // wrong.
            EXPECT_LE(far_wrong, far / 2000) << pcf << " across, resolution " << resolution;
            EXPECT_GT(double(far), (resolution == 1024 ? 0.85 : 0.25) * double(points.size()));
            const double share = double(wrong) / double(points.size());
            EXPECT_LE(share, 0.4 * before) << "a quarter with four times the texels along a side: edges are lines";
            EXPECT_GT(share, 0) << "edges are met at all";
            before = share;
        }
        EXPECT_LE(before, pcf == 0 ? 0.004 : 0.01);
    }
}

/// A single plate without anything that could cast a shadow on it.
Scene plate(const vec3& centre, const vec3& normal, float half_side_m, const PunctualLight& light) {
    const Frame frame(normal);
    const vec3 s = half_side_m * frame.tangent, t = half_side_m * frame.bitangent;
    Scene scene;
    test::add(scene, MeshBuilder().quad(centre - s - t, centre + s - t, centre + s + t, centre - s + t).build(0),
              test::lambert(0.5f));
    scene.punctual_lights = {light};
    finish_scene(scene);
    return scene;
}

TEST(LightDepthMaps, APlaneIsLitAllOverHoweverLightGrazesIt) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (const float degrees : {0.0f, 45.0f, 80.0f, 88.0f, 89.5f}) {
        for (int kind = 0; kind < 4; ++kind) {
            for (int turn = 0; turn < 4; ++turn) {
                const vec3 normal = unit_vector(random), centre = unit_vector(random);
                const Frame frame(normal);
                const float angle = degrees * kPi / 180, phi = 2 * kPi * random.next();
                const vec3 to_light = std::cos(angle) * normal + std::sin(angle) * (std::cos(phi) * frame.tangent +
                                                                                    std::sin(phi) * frame.bitangent);
                const vec3 place = centre + 2.0f * to_light;
                const PunctualLight light = kind == 0   ? test::point_light(place)
                                            : kind == 1 ? test::spot_light(place, -to_light, 30)
                                            : kind == 2 ? test::spot_light(place, -to_light, 80)
                                                        : test::sun(-to_light);
                const Lit scene(plate(centre, normal, 1.5f, light));
                const LightDepthMaps maps = scene.trace(32, 7);
                size_t dark = 0;
                for (int i = 0; i < 1000; ++i) {
                    const vec2 at = 3.0f * random.next_2d() - 1.5f;
                    const test::FacingPoint point{centre + at.x * frame.tangent + at.y * frame.bitangent, normal, 0};
                    const vec3 wi = test::towards(light, point.position).direction;
                    if (light.kind == PunctualLight::Kind::Spot && -glm::dot(light.direction, wi) <= light.cos_outer)
                        continue;  // outside of its cone
                    dark += scene.lit(maps, point, random.next_2d()) ? 0 : 1;
                }
                EXPECT_EQ(dark, 0u) << degrees << " degrees, light " << kind;
            }
        }
    }
}

// Facets of a sphere tilt against each other; from inside they rise towards the light.
TEST(LightDepthMaps, ASphereIsLitOnTheSideOfTheLightFromOutsideAndAllOverFromInside) {
    for (const vec3 place : {vec3(0, 0, 3), vec3(1.9f, -0.8f, 1), vec3(0.2f, -0.3f, 0.4f)}) {
        Scene scene;
        test::add(scene, make_icosphere(4, 0), test::lambert(0.5f));
        scene.punctual_lights = {test::point_light(place)};
        finish_scene(scene);
        const Lit sphere(std::move(scene));
        const std::vector<test::FacingPoint> points =
            test::facing_points(sphere.scene(), sphere.intersector(), 20000, 0.02f, 2);
        for (const uint32_t resolution : {16u, 128u}) {
            const LightDepthMaps maps = sphere.trace(resolution, 3);
            RandomStream random(resolution, RandomDomain::Test, 0, 0);
            size_t lit = 0, dark = 0;
            for (const test::FacingPoint& point : points) {
                if (!test::lit_by_ray(sphere.scene(), sphere.intersector(), point)) continue;
                ++lit, dark += sphere.lit(maps, point, random.next_2d()) ? 0 : 1;
            }
            EXPECT_GT(lit, 100u);
            EXPECT_EQ(dark, 0u) << "light at distance " << glm::length(place) << ", resolution " << resolution;
        }
    }
}

// A light in a box, and beads before each of 26 directions: face centres, seams of two faces, corners of three.
TEST(LightDepthMaps, CubesHaveNoSeams) {
    std::vector<vec3> directions;
    for (int i = 0; i < 27; ++i)
        if (i != 13) directions.push_back(glm::normalize(vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)));
    const vec3 place(0.02f, -0.01f, 0.03f);
    const auto wall = [&](const vec3& direction) {  // where the ray from the light meets the box
        const vec3 steps = (glm::sign(direction) * 2.0f - place) / direction;
        int axis = 0;
        for (int k = 1; k < 3; ++k)
            if (std::fabs(direction[k]) > 1e-6f && !(steps[axis] <= steps[k])) axis = k;
        vec3 normal(0);
        normal[axis] = direction[axis] > 0 ? -1.0f : 1.0f;
        return test::FacingPoint{place + steps[axis] * direction, normal, 0};
    };
    for (const bool beads : {false, true}) {
        MeshBuilder shapes;
        shapes.box(vec3(-2), vec3(2));
        if (beads)
            for (const vec3& direction : directions) shapes.sphere(place + 0.7f * direction, 0.1f, 64);
        Scene scene;
        test::add(scene, shapes.build(0), test::lambert(0.5f));
        scene.punctual_lights = {test::point_light(place)};
        finish_scene(scene);
        const Lit room(std::move(scene));
        const LightDepthMaps maps = room.trace(128, 3);
        RandomStream random(3, RandomDomain::Test, 0, 0);
        // Beads are seen within 0.1434 rad; three texels and a half are 0.055 rad where texels are largest.
        for (const vec3& direction : directions) {
            const Frame frame(direction);
            for (int i = 0; i < 2000; ++i) {
                const float r = 0.3f * std::sqrt(random.next()), phi = 2 * kPi * random.next();
                const vec3 aside = r * (std::cos(phi) * frame.tangent + std::sin(phi) * frame.bitangent);
                const float angle = std::atan(r);
                const bool near_edge = beads && std::fabs(angle - 0.1434f) < 0.06f;
                if (near_edge) continue;
                ASSERT_EQ(room.lit(maps, wall(glm::normalize(direction + aside)), random.next_2d()),
                          !beads || angle > 0.1434f)
                    << angle << " rad from (" << direction.x << ", " << direction.y << ", " << direction.z << ")";
            }
        }
    }
}

// A half plane over a plane: its shadow's edge is a ramp as wide as the filter, about where the light puts it.
TEST(LightDepthMaps, TheMeanOverTapsIsTheFiltersValue) {
    Scene scene;
    MeshBuilder shapes;
    shapes.quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1});
    shapes.quad({-1, 0.5f, 1}, {0, 0.5f, 1}, {0, 0.5f, -1}, {-1, 0.5f, -1});
    test::add(scene, shapes.build(0), test::lambert(0.5f));
    scene.punctual_lights = {test::sun({0, -1, 0})};
    finish_scene(scene);
    const Lit half(std::move(scene));
    constexpr uint32_t kResolution = 64;
    for (const uint32_t pcf : {0u, 1u, 3u, 8u}) {
        const LightDepthMaps maps = half.trace(kResolution, pcf);
        const float texel_m = 2 * maps.layout().maps[0].half_side / kResolution;
        constexpr int kSteps = 32;
        double last = 0;
        for (float x = -7; x <= 7; x += 0.23f) {  // [texels] from the edge
            double mean = 0;
            for (int i = 0; i < kSteps * kSteps; ++i) {
                const vec2 u = (vec2(i % kSteps, i / kSteps) + 0.5f) * (1.0f / kSteps);
                mean += half.lit(maps, {{x * texel_m, 0, 0.3f}, {0, 1, 0}, 0}, u) / double(kSteps * kSteps);
            }
            // The edge lies somewhere within a texel, and steps of u are a share of the filter.
            const double around = pcf == 0 ? 0.51 : (0.51 + double(pcf) / kSteps) / pcf;
            const double ramp = pcf == 0 ? (x > 0 ? 1 : 0) : std::clamp(0.5 + double(x) / pcf, 0.0, 1.0);
            if (pcf > 0 || std::fabs(x) > 0.51f) {
                EXPECT_NEAR(mean, ramp, pcf > 0 ? around : 0) << x << " texels from the edge, filter " << pcf;
            }
            EXPECT_GE(mean, last) << "the ramp rises";
            last = mean;
        }
    }
}

TEST(LightDepthMaps, OtherLightsAreNotKnown) {
    Scene scene = test::lit_room();
    test::add(scene, MeshBuilder().quad({-1, 3, -1}, {1, 3, -1}, {1, 3, 1}, {-1, 3, 1}).build(0),
              test::emitting(Rgb(1)));
    scene.environment.emplace();
    scene.environment->map.size = {2, 1};
    scene.environment->map.radiance.assign(2, Rgb(1));
    finish_scene(scene);
    const Lit room(std::move(scene));
    const LightDepthMaps maps = room.trace(16, 3);
    const auto seen = [&](uint32_t source) { return maps.seen(source, {0, 1, 0}, {0, 1, 0}, {0.5f, 0.5f}); };
    for (uint32_t instance = 0; instance < room.scene().instances.size(); ++instance)
        EXPECT_EQ(seen(light_source_of_instance(instance)), LightSeen::Unknown);
    EXPECT_EQ(seen(light_source_of_environment(room.scene())), LightSeen::Unknown);
    for (uint32_t light = 0; light < 4; ++light)
        EXPECT_NE(seen(light_source_of_punctual(room.scene(), light)), LightSeen::Unknown);
}

TEST(LightDepthMaps, AreTheSameForAnyNumberOfThreads) {
    const Lit room(test::lit_room());
    const LightDepthMaps one = test::on_threads(1, [&] { return room.trace(40, 3); });
    const LightDepthMaps four = test::on_threads(4, [&] { return room.trace(40, 3); });
    EXPECT_EQ(std::memcmp(one.depths_m().data(), four.depths_m().data(), one.depths_m().size_bytes()), 0);
}

// At the light itself, beyond everything, with no normal: an answer all the same.
TEST(LightDepthMaps, AnswersAnywhere) {
    const Lit room(test::lit_room());
    const LightDepthMaps maps = room.trace(16, 3);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (uint32_t light = 0; light < 4; ++light)
        for (const vec3& position : {room.scene().punctual_lights[light].position, vec3(1e9f), vec3(nan), vec3(0)})
            for (const vec3& normal : {vec3(0), vec3(0, 1, 0), vec3(nan)})
                EXPECT_NE(maps.seen(light_source_of_punctual(room.scene(), light), position, normal, {0.1f, 0.9f}),
                          LightSeen::Unknown);
}

TEST(LightDepthMaps, MoreTexelsThanNumbersAreRefused) {
    Scene scene = test::lit_room();
    scene.punctual_lights.resize(100, test::point_light(vec3(0)));
    try {
        const LightDepthLayout layout(scene, 8192, 3);
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Unsupported);
    }
}

}  // namespace
}  // namespace photond::light_depth_maps_test
