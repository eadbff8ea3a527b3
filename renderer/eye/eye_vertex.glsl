// GLSL twin of eye/eye_vertex.h: a path from the eye at a surface, before and after it scatters.
#ifndef PHOTOND_EYE_VERTEX_GLSL
#define PHOTOND_EYE_VERTEX_GLSL

#include "renderer/eye/eye_contributions.glsl"
#include "renderer/transport/bsdf_material.glsl"
#include "renderer/transport/roulette_shared.h"

/// A light sample that waits for its shadow ray; `wanted`: there is one.
struct PendingLight {
    Ray ray;
    vec3 radiance;
    bool indirect;
    bool wanted;
};
PendingLight no_pending_light() {
    return PendingLight(Ray(vec3(0.0), vec3(0.0), 0.0), vec3(0.0), false, false);
}

struct EyeVertex {
    ShadingPoint surface;
    Bsdf bsdf;
    vec3 wo;  // local to surface.shading
};

/// The surface at the end of the path's ray, and what is seen of it: the layers of the first hit, unlit radiance. False:
/// the path ends here, and nothing is emitted either.
bool see_surface(EyePath path, uint vertex, Hit hit, Ray ray, inout PathLight light, out ShadingPoint surface) {
    surface = make_shading_point(hit, ray.direction);
    if (vertex == 0)
        store_first_hit(path.pixel, surface.position, surface.shading.normal, surface.geometric_normal);
    if (!NEEDS_UNLIT || !has_flag(scene_materials[surface.material].flags, MATERIAL_UNLIT)) return true;
    if (path.scatterings > 0) return false;
    const vec3 radiance = unlit_radiance(hit.instance, hit.triangle, hit.u, hit.v);
    add_radiance(light, path, path.throughput * radiance);
    light.albedo = radiance;
    return false;
}

/// What the path's ray has gone through up to its hit; the environment, where it met nothing. False: it ends there.
bool arrive(inout EyePath path, Hit hit, Ray ray, inout PathLight light) {
    path.throughput *= transmittance(path.media, hit.t);
    if (hit_valid(hit)) return true;
    add_environment(light, path, ray.direction);
    return false;
}

bool is_emissive(uint material) {
    return NEEDS_AREA_LIGHTS && max_component(scene_materials[material].emission) > 0.0;
}

/// Makes ready to scatter at the surface seen, which is met.surface: its lobes, the place of its light samples, albedo.
/// False: it scatters no more.
bool open_surface(inout EyePath path, Ray ray, inout PathLight light, inout EyeVertex met) {
    met.bsdf = bsdf_nothing();
    met.wo = vec3(0.0, 0.0, 1.0);
    if (path.scatterings >= eye.max_scatterings) return false;
    met.bsdf = make_bsdf(met.surface,
                         medium_stack_outside_ior(path.media, met.surface.material, !met.surface.front_side));
    met.wo = to_local(met.surface.shading, -ray.direction);
    // The first non-delta surface: a walk that reaches another one left this one by a delta lobe.
    if (path.scatterings == 0 && layer_kept(LAYER_ALBEDO) && bsdf_has_non_delta(met.bsdf) && is_black(light.albedo))
        light.albedo = bsdf_albedo(met.bsdf);
    path.position = met.surface.position;
    path.lit_normal = bsdf_has_non_delta_transmission(met.bsdf) ? vec3(0.0) : met.surface.shading.normal;
    return true;
}

/// Both, and between them the light that the surface emits, weighed against light samples.
bool meet_surface(inout EyePath path, uint vertex, Hit hit, Ray ray, inout PathLight light, out EyeVertex met) {
    met.bsdf = bsdf_nothing();
    met.wo = vec3(0.0, 0.0, 1.0);
    if (!see_surface(path, vertex, hit, ray, light, met.surface)) return false;
    if (is_emissive(met.surface.material)) add_emission(light, path, hit, met.surface.front_side, ray.direction);
    return open_surface(path, ray, light, met);
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
