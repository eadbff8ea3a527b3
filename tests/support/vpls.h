#pragma once
// Virtual point lights on the surfaces of a scene, for tests of what is between them.

#include <span>
#include <vector>

#include "renderer/core/rng.h"
#include "renderer/many_lights/vpl.h"
#include "renderer/transport/emission_sampling.h"
#include "renderer/transport/sampling.h"
#include "renderer/transport/surface.h"

namespace photond::test {

/// Where light from the scene's lights first falls, and falls from there: half of them each. Lambert, 1 W/sr.
inline std::vector<gpu::Vpl> vpls_on(const Scene& scene, const Intersector& intersector, size_t count, uint64_t seed) {
    const EmissionSampler emission(scene);
    RandomStream random(seed, RandomDomain::Test, 0, 0);
    std::vector<gpu::Vpl> vpls;
    const auto add = [&](const Ray& ray, uint32_t scatterings) {
        const Hit hit = intersector.closest_hit(ray);
        if (!hit.valid() || vpls.size() == count) return false;
        const ShadingPoint point = make_plain_shading_point(scene, hit, ray.direction);
        vpls.push_back({.position = point.position,
                        .correction = 1,
                        .normal = point.geometric_normal,
                        .intensity = vec3(1),
                        .surface = NO_VPL_SURFACE,
                        .scatterings = scatterings});
        return true;
    };
    for (size_t tries = 0; vpls.size() < count && tries < 1000 * count; ++tries) {
        EmissionSample sample;
        const float u_light = random.next();
        const vec2 u_position = random.next_2d(), u_direction = random.next_2d(), u_next = random.next_2d();
        if (!emission.sample(u_light, u_position, u_direction, sample) || !add(sample.ray, 1)) continue;
        const gpu::Vpl& first = vpls.back();
        add({offset_ray_origin(first.position, first.normal),
             Frame(first.normal).to_world(sample_cosine_hemisphere(u_next))},
            2);
    }
    return vpls;
}

/// Share of what light would carry from `vpls` to `points` (whose normals count) that occluded(light, point) answers
/// wrongly for, as rays say.
template <class Occluded>
double wrong_share(const Scene& scene, const Intersector& intersector, std::span<const gpu::Vpl> vpls,
                   std::span<const gpu::Vpl> points, const Occluded& occluded) {
    double wrong = 0, all = 0;
    const float clamp_sq_m2 = sqr(0.05f * scene.bounds.radius());
    for (size_t light = 0; light < vpls.size(); ++light)
        for (const gpu::Vpl& point : points) {
            const vec3 way = point.position - vpls[light].position;
            const float distance_sq_m2 = glm::dot(way, way);
            const float cosines = std::max(glm::dot(way, vpls[light].normal), 0.0f) *
                                  std::max(-glm::dot(way, point.normal), 0.0f) / distance_sq_m2;
            if (!(cosines > 0)) continue;
            const double carried = cosines * clamped_falloff(distance_sq_m2, clamp_sq_m2);
            const vec3 from = offset_ray_origin(vpls[light].position, vpls[light].normal);
            const vec3 to = offset_ray_origin(point.position, point.normal) - from;
            if (intersector.occluded(Ray{from, to, 1}) != occluded(light, point.position)) wrong += carried;
            all += carried;
        }
    return wrong / all;
}

}  // namespace photond::test
