#include "renderer/methods/image_based_lighting/lamp_rays.h"

#include "renderer/transport/emission.h"
#include "renderer/transport/mis.h"

namespace photond {

void LampRays::take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) {
    if (next_) next_->take(lambert, others);
    if (!draws_lamp_rays(eye_.scene.needs)) return;
    std::vector<Rgb>& direct = image_.of<Layer::Direct>();
    for (const LambertVisiblePoint& point : lambert) direct[point.pixel] += lamp_met(walk_.general(point));
    for (const VisiblePoint& point : others) direct[point.pixel] += lamp_met(point);
    counts_.bounce_rays += lambert.size() + others.size();
}

/// Radiance of the lamp that a ray of the point's lobes meets.
Rgb LampRays::lamp_met(const VisiblePoint& point) const {
    const float u_lobe = sampler_.sample_2d(point.path_key, sample_set(point.vertex, VertexSet::Lobe)).y;
    const vec2 u = sampler_.sample_2d(point.path_key, sample_set(point.vertex, VertexSet::Direction));
    const BsdfSample sample = point.rough.sample(point.wo, u_lobe, u);
    if (!sample.valid()) return Rgb(0);
    const vec3 direction = point.surface.shading.to_world(sample.wi);
    const Hit hit = eye_.intersector.closest_hit({ray_origin(point.surface, direction), direction, kInfinity});
    if (!hit.valid()) return Rgb(0);
    const ShadingPoint met = make_shading_point(eye_.scene, hit, direction);
    if (!eye_.scene.materials[met.material].emissive()) return Rgb(0);
    const Rgb emitted = emitted_radiance(eye_.scene, {hit.instance, hit.triangle, hit.u, hit.v}, met.front_side);
    const float light_pdf = eye_.lights.pdf_triangle(point.surface.position, point.lit_normal, hit.instance,
                                                     hit.triangle, direction, hit.t);
    return power_heuristic(sample.pdf_sa, light_pdf) * point.throughput * sample.weight * emitted;
}

}  // namespace photond
