#pragma once
// A furnished room with punctual lights of every kind, and points on its surfaces, for tests of shadows.

#include <optional>
#include <vector>

#include "renderer/core/rng.h"
#include "renderer/scene/intersector.h"
#include "tests/support/scene_parts.h"

namespace photond::test {

inline PunctualLight point_light(const vec3& position) {
    PunctualLight light;
    light.kind = PunctualLight::Kind::Point;
    light.position = position;
    return light;
}
inline PunctualLight spot_light(const vec3& position, const vec3& direction, float half_angle_degrees) {
    PunctualLight light = point_light(position);
    light.kind = PunctualLight::Kind::Spot;
    light.direction = glm::normalize(direction);
    light.cos_outer = std::cos(half_angle_degrees * kPi / 180);
    light.cos_inner = std::cos(0.5f * half_angle_degrees * kPi / 180);
    return light;
}
inline PunctualLight sun(const vec3& direction) {
    PunctualLight light;
    light.kind = PunctualLight::Kind::Directional;
    light.direction = glm::normalize(direction);
    return light;
}

/// 4 x 3 x 4 m, open to the front and above, with boxes, a sphere, a torus and thin poles. Lights: a point, a spot that
/// has a map of its cone, one that is too wide for it, and a sun.
inline Scene lit_room() {
    MeshBuilder shapes;
    shapes.quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2});    // floor
    shapes.quad({-2, 0, -2}, {2, 0, -2}, {2, 3, -2}, {-2, 3, -2});  // back
    shapes.quad({-2, 0, 2}, {-2, 0, -2}, {-2, 3, -2}, {-2, 3, 2});  // left
    shapes.quad({2, 0, -2}, {2, 0, 2}, {2, 3, 2}, {2, 3, -2});      // right
    shapes.box({-1.2f, 0, -1.1f}, {-0.4f, 1.3f, -0.3f});
    shapes.box({0.5f, 0, 0.1f}, {1.1f, 0.5f, 0.9f});
    shapes.sphere({0.8f, 0.9f, 0.5f}, 0.4f, 48);
    shapes.torus({-0.6f, 0.6f, 0.8f}, 0.4f, 0.12f, 48, 24);
    for (int pole = 0; pole < 5; ++pole) shapes.cylinder({-1.6f + 0.7f * float(pole), 0, -1.6f}, 0.04f, 2.2f, 16);
    Scene scene;
    add(scene, shapes.build(0), lambert(0.5f));
    scene.punctual_lights = {point_light({0.3f, 2.1f, -0.2f}), spot_light({1.6f, 2.6f, 1.7f}, {-1, -1.1f, -1}, 35),
                             spot_light({-1.7f, 2.5f, 1.5f}, {1, -1, -0.8f}, 75), sun({0.4f, -1, -0.5f})};
    finish_scene(scene);
    return scene;
}

/// The room with its punctual lights, two-sided, one-sided and mirrored lamps, and a sky.
inline Scene room_of_all_lights() {
    Scene scene = lit_room();
    Material lamp = lambert(0);
    lamp.emission = Rgb(3, 2, 1);
    MeshBuilder quads, triangle;
    quads.quad({-0.5f, 2.5f, -0.5f}, {-0.5f, 2.5f, 0.5f}, {0.5f, 2.5f, 0.5f}, {0.5f, 2.5f, -0.5f});
    add(scene, quads.build(0), lamp);
    triangle.triangle({-1.8f, 0.4f, 1}, {-1.7f, 0.9f, 1}, {-1.6f, 0.4f, 1.3f});
    lamp.double_sided = true;
    add(scene, triangle.build(0), lamp);
    Environment sky;
    sky.map = {{4, 2}, {Rgb(1), Rgb(2), Rgb(0.5f), Rgb(0.1f), Rgb(1), Rgb(4), Rgb(0.2f), Rgb(1)}};
    scene.environment = sky;
    finish_scene(scene);
    return scene;
}

/// A point of a surface that faces a light.
struct FacingPoint {
    vec3 position;
    vec3 normal;  // geometric, on the light's side
    uint32_t light;
};

/// Unit vector to the light, and how far it is.
inline Ray towards(const PunctualLight& light, const vec3& position) {
    if (light.kind == PunctualLight::Kind::Directional) return {position, -light.direction};
    const float distance = glm::length(light.position - position);
    return {position, (light.position - position) / distance, distance};
}

/// Where random rays within the bounds end, with the lights in turn; those that light cannot reach are left out.
inline std::vector<FacingPoint> facing_points(const Scene& scene, const Intersector& intersector, size_t rays,
                                              float least_cosine, uint64_t seed) {
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    std::vector<FacingPoint> points;
    for (size_t i = 0; i < rays; ++i) {
        const vec3 u(random.next(), random.next(), random.next());
        const float z = 2 * random.next() - 1, phi = 2 * kPi * random.next(), r = std::sqrt(std::max(0.0f, 1 - z * z));
        const Ray ray{scene.bounds.min + u * scene.bounds.diagonal(), {r * std::cos(phi), r * std::sin(phi), z}};
        const Hit hit = intersector.closest_hit(ray);
        if (!hit.valid()) continue;
        const TriangleCorners corners = world_triangle(scene, hit.instance, hit.triangle);
        const vec3 *p = corners.p, position = (1 - hit.u - hit.v) * p[0] + hit.u * p[1] + hit.v * p[2];
        vec3 normal = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
        if (glm::dot(normal, ray.direction) > 0) normal = -normal;
        const auto index = static_cast<uint32_t>(i % scene.punctual_lights.size());
        const PunctualLight& light = scene.punctual_lights[index];
        const vec3 to_light = towards(light, position).direction;
        if (glm::dot(normal, to_light) < least_cosine) continue;
        if (light.kind == PunctualLight::Kind::Spot && -glm::dot(light.direction, to_light) <= light.cos_outer)
            continue;
        points.push_back({position, normal, index});
    }
    return points;
}

/// Whether a shadow ray reaches the light.
inline bool lit_by_ray(const Scene& scene, const Intersector& intersector, const FacingPoint& point) {
    Ray ray = towards(scene.punctual_lights[point.light], point.position);
    ray.origin = offset_ray_origin(point.position, point.normal);
    return !intersector.occluded(ray);
}

}  // namespace photond::test
