// Shading of any hit, one by one.

#include "renderer/eye/eye_vertex.h"
#include "renderer/eye/path_wavefront.h"
#include "renderer/transport/bsdf.h"
#include "renderer/transport/hit_prefetch.h"

namespace photond {

void PathWavefront::shade_general(const PathScene& shared, uint32_t vertex, PassImage& image) {
    for (size_t k = 0; k < batch_.general.size(); ++k) {
        prefetch_ahead(shared.scene, batch_.hits, batch_.general, k);
        const uint32_t i = batch_.general[k];
        if (shade_vertex(shared, vertex, i, image)) batch_.keep_next(batch_.keys[i]);
    }
}

/// Adds what path i finds at the end of its ray, draws a light sample there and the next ray. False: the path ends, and
/// what stands in the place of the next path does not count.
bool PathWavefront::shade_vertex(const PathScene& shared, uint32_t vertex, uint32_t i, PassImage& image) {
    EyePath& path = batch_.next_path();
    path = batch_.paths[i];
    const bool camera_walk = path.scatterings == 0;
    EyeVertex met;
    if (!meet_surface(shared, path, vertex, batch_.hits[i], batch_.rays[i], image, met)) return false;
    const auto& [point, bsdf, wo] = met;

    LightSample light;
    if (bsdf.has_non_delta() && shared.lights.sample(path.position, path.lit_normal, choice_.x[i],
                                                     {light_point_.x[i], light_point_.y[i]}, light)) {
        const BsdfValue f = bsdf.evaluate(wo, point.shading.to_local(light.wi));
        if (!is_black(f.f_cos)) {
            const float weight = light.delta ? 1.0f : power_heuristic(light.pdf_sa, f.pdf_sa);
            shadows_.add(light.shadow_ray(ray_origin(point, light.wi)),
                         {weight * path.throughput * f.f_cos * light.radiance_over_pdf, path.pixel, !camera_walk});
        }
    }

    return leave_surface(path, point, bsdf.sample(wo, lobe_.x[i], {direction_.x[i], direction_.y[i]}),
                         vertex + 1 >= shared.roulette_start, choice_.y[i], image, batch_.next_ray());
}

}  // namespace photond
