#pragma once
// A path from the eye at a surface: what it does there whatever the method, before and after it scatters.

#include "renderer/eye/eye_contributions.h"
#include "renderer/transport/bsdf.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

struct EyeVertex {
    ShadingPoint surface;
    Bsdf bsdf;
    vec3 wo{0};  // local to surface.shading
};

/// Adds what the path sees at the end of its ray: the layers of the first hit, unlit radiance, emission, albedo. The
/// place of its light samples is set. False: the path ends here.
inline bool meet_surface(const EyeScene& shared, EyePath& path, uint32_t vertex, const Hit& hit, const Ray& ray,
                         PassImage& image, EyeVertex& met) {
    const Scene& scene = shared.scene;
    met.surface = make_shading_point(scene, hit, ray.direction);
    const ShadingPoint& surface = met.surface;
    const Material& material = scene.materials[surface.material];
    if (vertex == 0)
        store_first_hit(image, shared, path.pixel, surface.position, surface.shading.normal, surface.geometric_normal);
    const bool camera_walk = path.scatterings == 0;
    if (material.unlit) {
        if (!camera_walk) return false;
        const Rgb radiance = unlit_radiance(scene, {hit.instance, hit.triangle, hit.u, hit.v});
        add_radiance(image, path, path.throughput * radiance);
        if (image.layers.has(Layer::Albedo)) image.of<Layer::Albedo>()[path.pixel] = radiance;
        return false;
    }
    if (material.emissive()) add_emission(image, shared, path, hit, surface.front_side, ray.direction);
    if (path.scatterings >= shared.max_scatterings) return false;

    met.bsdf = make_bsdf(scene, surface, path.media.outside_ior(scene, surface.material, !surface.front_side));
    met.wo = surface.shading.to_local(-ray.direction);
    // The first non-delta surface: a walk that reaches another one left this one by a delta lobe.
    if (camera_walk && image.layers.has(Layer::Albedo) && met.bsdf.has_non_delta() &&
        is_black(image.of<Layer::Albedo>()[path.pixel]))
        image.of<Layer::Albedo>()[path.pixel] = met.bsdf.albedo();
    path.position = surface.position;
    path.lit_normal = met.bsdf.has_non_delta_transmission() ? vec3(0) : surface.shading.normal;
    return true;
}

/// Sends the path on as sampled; with `roulette`, a number in [0, 1), it may end by Russian roulette. False: it ends.
inline bool leave_surface(EyePath& path, const ShadingPoint& surface, const BsdfSample& next, bool with_roulette,
                          float roulette, PassImage& image, Ray& ray) {
    if (!next.valid()) return false;
    const bool camera_walk = path.scatterings == 0;
    path.throughput *= next.weight;
    path.pdf_sa = next.pdf_sa;
    path.delta = next.delta;
    if (!(camera_walk && next.delta)) {
        path.caustic = camera_walk || (path.caustic && next.delta);
        ++path.scatterings;
    }
    if (next.refraction) {
        path.eta_scale *= sqr(next.eta);
        path.media.cross(surface.material, surface.front_side);
    }
    if (!is_finite(path.throughput)) {  // shown, not hidden: the film drops and counts it
        add_radiance(image, path, path.throughput);
        return false;
    }
    // What the throughput would be outside of all solids decides: inside, radiance is larger by the squared index.
    const float hope = max_component(path.throughput) * path.eta_scale;
    if (!(hope > 0)) return false;
    if (with_roulette) {
        const float survival = std::min(hope, ROULETTE_MOST_SURVIVAL);
        if (roulette >= survival) return false;
        path.throughput /= survival;
    }
    const vec3 wi = surface.shading.to_world(next.wi);
    ray = {ray_origin(surface, wi), wi, kInfinity};
    return true;
}

}  // namespace photond
