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

/// The surface at the end of the path's ray, and what is seen of it: the layers of the first hit, unlit radiance.
/// False: the path ends here, and nothing is emitted either.
inline bool see_surface(const EyeScene& shared, const EyePath& path, uint32_t vertex, const Hit& hit, const Ray& ray,
                        PassImage& image, ShadingPoint& surface) {
    surface = make_shading_point(shared.scene, hit, ray.direction);
    if (vertex == 0)
        store_first_hit(image, shared, path.pixel, surface.position, surface.shading.normal, surface.geometric_normal);
    if (!shared.scene.materials[surface.material].unlit) return true;
    if (path.scatterings > 0) return false;
    const Rgb radiance = unlit_radiance(shared.scene, {hit.instance, hit.triangle, hit.u, hit.v});
    add_radiance(image, path, path.throughput * radiance);
    if (image.layers.has(Layer::Albedo)) image.of<Layer::Albedo>()[path.pixel] = radiance;
    return false;
}

/// Makes ready to scatter at the surface seen: its lobes, the place of its light samples, albedo. False: it scatters
/// no more.
inline bool open_surface(const EyeScene& shared, EyePath& path, const Ray& ray, PassImage& image, EyeVertex& met) {
    if (path.scatterings >= shared.max_scatterings) return false;
    const ShadingPoint& surface = met.surface;
    met.bsdf =
        make_bsdf(shared.scene, surface, path.media.outside_ior(shared.scene, surface.material, !surface.front_side));
    met.wo = surface.shading.to_local(-ray.direction);
    // The first non-delta surface: a walk that reaches another one left this one by a delta lobe.
    if (path.scatterings == 0 && image.layers.has(Layer::Albedo) && met.bsdf.has_non_delta() &&
        is_black(image.of<Layer::Albedo>()[path.pixel]))
        image.of<Layer::Albedo>()[path.pixel] = met.bsdf.albedo();
    path.position = surface.position;
    path.lit_normal = met.bsdf.has_non_delta_transmission() ? vec3(0) : surface.shading.normal;
    return true;
}

/// Both, and between them the light that the surface emits, weighed against light samples.
inline bool meet_surface(const EyeScene& shared, EyePath& path, uint32_t vertex, const Hit& hit, const Ray& ray,
                         PassImage& image, EyeVertex& met) {
    if (!see_surface(shared, path, vertex, hit, ray, image, met.surface)) return false;
    if (shared.scene.materials[met.surface.material].emissive())
        add_emission(image, shared, path, hit, met.surface.front_side, ray.direction);
    return open_surface(shared, path, ray, image, met);
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
