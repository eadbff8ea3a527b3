// Shading of hits on plain Lambert reflectors: what path_wavefront_general.cpp does, for as many paths at once as the
// machine has lanes. Textures and the choice of a point on a light are left to one at a time.

#include "renderer/eye/eye_contributions.h"
#include "renderer/eye/path_wavefront.h"
#include "renderer/transport/lambert_lanes.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

void PathWavefront::shade_lambert(const PathScene& shared, uint32_t vertex, PassImage& image) {
    const bool roulette = vertex + 1 >= shared.roulette_start;
    LambertGroup group;
    for (size_t first = 0; first < batch_.lambert.size(); first += kLanes) {
        const size_t lanes = batch_.gather_lambert(shared, first, group, [&](size_t lane, uint32_t i) {
            group.sample_x[lane] = direction_.x[i];
            group.sample_y[lane] = direction_.y[i];
            group.roulette[lane] = roulette ? choice_.y[i] : 0.0f;
        });
        group.find_surface();
        group.scatter(roulette, ROULETTE_MOST_SURVIVAL);

        for (size_t lane = 0; lane < lanes; ++lane) {
            const uint32_t i = batch_.lambert[first + lane];
            const EyePath& path = batch_.paths[i];
            const Hit& hit = batch_.hits[i];
            const vec3 position = group.position.get(lane), normal = group.normal.get(lane);
            const Rgb reflectance = group.reflectance.get(lane);
            if (vertex == 0)
                store_first_hit(image, shared, path.pixel, position, normal, group.geometric_normal.get(lane));
            if (shared.shading[hit.instance].emits)
                add_emission(image, shared, path, hit, group.front[lane] != 0, batch_.rays[i].direction);
            if (path.scatterings >= shared.max_scatterings || is_black(reflectance)) continue;
            const bool camera_walk = path.scatterings == 0;
            if (camera_walk && image.layers.has(Layer::Albedo) && is_black(image.of<Layer::Albedo>()[path.pixel]))
                image.of<Layer::Albedo>()[path.pixel] = reflectance;

            const vec3 start = group.start.get(lane);
            LightSample light;
            if (shared.lights.sample(position, normal, choice_.x[i], {light_point_.x[i], light_point_.y[i]}, light)) {
                const float cos_light = glm::dot(normal, light.wi);
                if (cos_light > 0 && glm::dot(group.geometric_normal.get(lane), light.wi) > 0) {
                    const float pdf_sa = cos_light * kInvPi;
                    const float weight = light.delta ? 1.0f : power_heuristic(light.pdf_sa, pdf_sa);
                    shadows_.add(light.shadow_ray(start),
                                 {(weight * pdf_sa) * path.throughput * reflectance * light.radiance_over_pdf,
                                  path.pixel, !camera_walk});
                }
            }
            if (group.scattered[lane] == 0) continue;
            EyePath& next = batch_.next_path();
            next = path;
            next.throughput *= reflectance * group.survival_inverse[lane];
            next.pdf_sa = group.cos_next[lane] * kInvPi;
            next.position = position;
            next.lit_normal = normal;
            next.delta = false;
            next.caustic = camera_walk;
            ++next.scatterings;
            batch_.next_ray() = {start, group.next_direction.get(lane), kInfinity};
            batch_.keep_next(batch_.keys[i]);
        }
    }
}

}  // namespace photond
