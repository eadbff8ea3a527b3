// Shading of any hit, one by one.

#include "renderer/methods/eye_contributions.h"
#include "renderer/methods/path_tracing/wavefront.h"
#include "renderer/transport/bsdf.h"
#include "renderer/transport/hit_prefetch.h"

namespace photond {

void Wavefront::shade_general(const PathTracingScene& shared, uint32_t vertex, PassImage& image) {
    for (size_t k = 0; k < general_.size(); ++k) {
        prefetch_ahead(shared.scene, hits_, general_, k);
        const uint32_t i = general_[k];
        if (shade_vertex(shared, vertex, i, image)) next_keys_[next_count_++] = keys_[i];
    }
}

/// Adds what path i finds at the end of its ray, draws a light sample there and the next ray. False: the path ends, and
/// what stands in the place of the next path does not count.
bool Wavefront::shade_vertex(const PathTracingScene& shared, uint32_t vertex, uint32_t i, PassImage& image) {
    const Scene& scene = shared.scene;
    EyePath& path = next_paths_[next_count_];
    path = paths_[i];
    const Ray& ray = rays_[i];
    const Hit& hit = hits_[i];

    const ShadingPoint point = make_shading_point(scene, hit, ray.direction);
    const Material& material = scene.materials[point.material];
    if (vertex == 0) store_first_hit(image, shared, path.pixel, point.position, point.shading.normal);
    const bool camera_walk = path.scatterings == 0;
    if (material.unlit) {
        if (!camera_walk) return false;
        const Rgb radiance = unlit_radiance(scene, {hit.instance, hit.triangle, hit.u, hit.v});
        add_radiance(image, path, path.throughput * radiance);
        if (!image.albedo.empty()) image.albedo[path.pixel] = radiance;
        return false;
    }
    if (material.emissive()) add_emission(image, shared, path, hit, point.front_side, ray.direction);
    if (path.scatterings >= shared.max_scatterings) return false;

    const Bsdf bsdf = make_bsdf(scene, point, path.media.outside_ior(scene, point.material, !point.front_side));
    const vec3 wo = point.shading.to_local(-ray.direction);
    // The first non-delta surface: a walk that reaches another one left this one by a delta lobe.
    if (camera_walk && !image.albedo.empty() && bsdf.has_non_delta() && is_black(image.albedo[path.pixel]))
        image.albedo[path.pixel] = bsdf.albedo();

    path.position = point.position;
    path.lit_normal = bsdf.has_non_delta_transmission() ? vec3(0) : point.shading.normal;
    LightSample light;
    if (bsdf.has_non_delta() && shared.lights.sample(path.position, path.lit_normal, choice_.x[i],
                                                     {light_point_.x[i], light_point_.y[i]}, light)) {
        const BsdfValue f = bsdf.evaluate(wo, point.shading.to_local(light.wi));
        if (!is_black(f.f_cos)) {
            const float weight = light.delta ? 1.0f : power_heuristic(light.pdf_sa, f.pdf_sa);
            shadow_rays_[shadow_count_] = light.shadow_ray(ray_origin(point, light.wi));
            pending_[shadow_count_++] = {weight * path.throughput * f.f_cos * light.radiance_over_pdf, path.pixel,
                                         !camera_walk};
        }
    }

    const BsdfSample next = bsdf.sample(wo, lobe_.x[i], {direction_.x[i], direction_.y[i]});
    if (!next.valid()) return false;
    path.throughput *= next.weight;
    path.pdf_sa = next.pdf_sa;
    path.delta = next.delta;
    if (!(camera_walk && next.delta)) {
        path.caustic = camera_walk || (path.caustic && next.delta);
        ++path.scatterings;
    }
    if (next.refraction) {
        path.eta_scale *= sqr(next.eta);
        path.media.cross(point.material, point.front_side);
    }

    if (!is_finite(path.throughput)) {  // shown, not hidden: the film drops and counts it
        add_radiance(image, path, path.throughput);
        return false;
    }
    // What the throughput would be outside of all solids decides: inside, radiance is larger by the squared index.
    const float hope = max_component(path.throughput) * path.eta_scale;
    if (!(hope > 0)) return false;
    if (vertex + 1 >= shared.roulette_start) {
        const float survival = std::min(hope, kMaxSurvival);
        if (choice_.y[i] >= survival) return false;
        path.throughput /= survival;
    }
    const vec3 wi = point.shading.to_world(next.wi);
    next_rays_[next_count_] = {ray_origin(point, wi), wi, kInfinity};
    return true;
}

}  // namespace photond
