// GLSL twin of eye/eye_vertex.h: a path from the eye at a surface, before and after it scatters.
#ifndef PHOTOND_EYE_VERTEX_GLSL
#define PHOTOND_EYE_VERTEX_GLSL

#include "renderer/eye/eye_contributions.glsl"
#include "renderer/transport/bsdf_material.glsl"
#include "renderer/transport/roulette_shared.h"

struct EyeVertex {
    ShadingPoint surface;
    Bsdf bsdf;
    vec3 wo;  // local to surface.shading
};

/// Adds what the path sees at the end of its ray: the layers of the first hit, unlit radiance, emission, albedo. The place
/// of its light samples is set. False: the path ends here.
bool meet_surface(inout EyePath path, uint vertex, Hit hit, Ray ray, inout PathLight light, out EyeVertex met) {
    met.surface = make_shading_point(hit, ray.direction);
    met.bsdf = bsdf_nothing();
    met.wo = vec3(0.0, 0.0, 1.0);
    const uint flags = scene_materials[met.surface.material].flags;
    if (vertex == 0)
        store_first_hit(path.pixel, met.surface.position, met.surface.shading.normal, met.surface.geometric_normal);
    const bool camera_walk = path.scatterings == 0;
    if (NEEDS_UNLIT && has_flag(flags, MATERIAL_UNLIT)) {
        if (!camera_walk) return false;
        const vec3 radiance = unlit_radiance(hit.instance, hit.triangle, hit.u, hit.v);
        add_radiance(light, path, path.throughput * radiance);
        light.albedo = radiance;
        return false;
    }
    if (NEEDS_AREA_LIGHTS && max_component(scene_materials[met.surface.material].emission) > 0.0)
        add_emission(light, path, hit, met.surface.front_side, ray.direction);
    if (path.scatterings >= eye.max_scatterings) return false;

    met.bsdf = make_bsdf(met.surface,
                         medium_stack_outside_ior(path.media, met.surface.material, !met.surface.front_side));
    met.wo = to_local(met.surface.shading, -ray.direction);
    // The first non-delta surface: a walk that reaches another one left this one by a delta lobe.
    if (camera_walk && layer_kept(PLANE_ALBEDO) && bsdf_has_non_delta(met.bsdf) && is_black(light.albedo))
        light.albedo = bsdf_albedo(met.bsdf);
    path.position = met.surface.position;
    path.lit_normal = bsdf_has_non_delta_transmission(met.bsdf) ? vec3(0.0) : met.surface.shading.normal;
    return true;
}

/// Sends the path on as sampled; with `roulette`, a number in [0, 1), it may end by Russian roulette. False: it ends.
bool leave_surface(inout EyePath path, ShadingPoint surface, BsdfSample next, bool with_roulette, float roulette,
                   inout PathLight light, inout Ray ray) {
    if (!(next.pdf_sa > 0.0)) return false;
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
        medium_stack_cross(path.media, surface.material, surface.front_side);
    }
    if (!is_finite(path.throughput)) {  // shown, not hidden: the film drops and counts it
        add_radiance(light, path, path.throughput);
        return false;
    }
    // What the throughput would be outside of all solids decides: inside, radiance is larger by the squared index.
    const float hope = max_component(path.throughput) * path.eta_scale;
    if (!(hope > 0.0)) return false;
    if (with_roulette) {
        const float survival = min(hope, ROULETTE_MOST_SURVIVAL);
        if (roulette >= survival) return false;
        path.throughput /= survival;
    }
    const vec3 wi = to_world(surface.shading, next.wi);
    ray = Ray(ray_origin(surface, wi), wi, INFINITY);
    return true;
}

#endif
