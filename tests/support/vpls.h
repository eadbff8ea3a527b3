#pragma once
// Virtual point lights on the surfaces of a scene, for tests of what is between them.

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

}  // namespace photond::test
