// GLSL twin of eye/specular_walk.cpp: from the eye through what is specular, a vertex at a time. What a vertex does is
// said in specular_walk.h.
//
// A method that knows of shadows before a ray is traced (WalkGuide::light_seen()) defines before
// WALK_LIGHT_SEEN(position, normal, source, key): a LIGHT_SEEN_* of a light source (LightSample::source) at a point;
// `normal` is geometric, on the eye's side, `key` the path's of the sampler. One that draws rays by f_d which will meet
// lights defines WALK_COMPETING_RAYS, how many at each vertex (WalkVertex::competing_rays of specular_walk.h).
#ifndef PHOTOND_SPECULAR_WALK_GLSL
#define PHOTOND_SPECULAR_WALK_GLSL

#include "renderer/eye/eye_vertex.glsl"
#include "renderer/transport/light_seen.glsl"

#ifndef WALK_LIGHT_SEEN
#define WALK_LIGHT_SEEN(position, normal, source, key) LIGHT_SEEN_UNKNOWN
#endif
#ifndef WALK_COMPETING_RAYS
#define WALK_COMPETING_RAYS 0.0
#endif

/// A vertex of the walk: where a path is, and what of its light is still to come.
struct WalkVertex {
    Hit hit;
    vec3 ray_direction;  // of the ray that met the surface: with `hit` it makes `surface` again
    ShadingPoint surface;
    float outside_ior;  // as make_bsdf() wants it
    Bsdf rough;         // f_d
    vec3 wo;            // local to surface.shading
    vec3 throughput;    // of the path up to here
    float eta_scale;    // as EyePath's
    MediumStack media;
    uint scatterings;  // of the path before this vertex
    bool waits;        // a visible point: f_d scatters, and one more scattering, before it, is within eye.max_scatterings
};

/// Light samples at a vertex: the radiance of one, and the ray that must not be occluded for it to arrive. The specular
/// part's share of it competes with the direction that the path goes on to, the rough part's with `competing_rays` that the
/// method draws. `samples`: of the vertex in all. False: it carries nothing.
bool walk_light_sample(EyePath path, WalkVertex met, Bsdf specular, float samples, float competing_rays, float u_choice,
                       vec2 u_light, out Ray ray, out vec3 radiance, out LightSample light_sample) {
    ray = Ray(vec3(0.0), vec3(0.0), 0.0);
    radiance = vec3(0.0);
    if (!sample_light(path.position, path.lit_normal, u_choice, u_light, light_sample)) return false;
    const vec3 wi = to_local(met.surface.shading, light_sample.wi);
    const BsdfValue by_rough = bsdf_evaluate(met.rough, met.wo, wi, TRANSPORT_RADIANCE);
    vec3 f_cos = by_rough.f_cos;
    if (!light_sample.delta && competing_rays > 0.0)
        f_cos *= power_heuristic(samples * light_sample.pdf_sa, competing_rays * by_rough.pdf_sa);
    if (bsdf_scatters(specular)) {
        const BsdfValue by_specular = bsdf_evaluate(specular, met.wo, wi, TRANSPORT_RADIANCE);
        f_cos += (light_sample.delta ? 1.0 : power_heuristic(samples * light_sample.pdf_sa, by_specular.pdf_sa)) *
                 by_specular.f_cos;
    }
    if (is_black(f_cos)) return false;
    radiance = path.throughput * f_cos * light_sample.radiance_over_pdf / samples;
    ray = shadow_ray(light_sample, ray_origin(met.surface, light_sample.wi));
    return true;
}

/// Follows the path's ray to the next vertex and adds what it finds there to `light`, but for light samples. False: it ends.
bool walk_meet(uint vertex, float glossy_threshold, inout EyePath path, Ray ray, inout PathLight light,
               out WalkVertex met, out Bsdf specular) {
    met.waits = false;
    met.hit = closest_hit(ray);
    if (!arrive(path, met.hit, ray, light)) return false;
    EyeVertex at;
    met.ray_direction = ray.direction;
    if (!meet_surface(path, vertex, met.hit, ray, light, at)) return false;
    met.surface = at.surface;
    met.outside_ior = medium_stack_outside_ior(path.media, at.surface.material, !at.surface.front_side);
    met.wo = at.wo;
    met.throughput = path.throughput;
    met.eta_scale = path.eta_scale;
    met.media = path.media;
    met.scatterings = path.scatterings;
    specular = bsdf_specular_part(at.bsdf, glossy_threshold);
    met.rough = bsdf_rough_part(at.bsdf, glossy_threshold);
    met.waits = bsdf_scatters(met.rough) && path.scatterings + 2 <= eye.max_scatterings;
    return true;
}

/// Draws the path's next ray by the specular part; `roulette`: a number for it. False: the path ends.
bool walk_leave(uint vertex, uint key, WalkVertex met, Bsdf specular, float roulette, inout EyePath path,
                inout PathLight light, inout Ray ray) {
    if (!bsdf_scatters(specular)) return false;
    const float u_lobe = sample_2d(key, sample_set(vertex, SET_LOBE)).x;
    const vec2 u_direction = sample_2d(key, sample_set(vertex, SET_DIRECTION));
    return leave_surface(path, met.surface, bsdf_sample(specular, met.wo, u_lobe, u_direction),
                         vertex + 1 >= eye.roulette_start, roulette, light, ray);
}

#ifdef WALK_KEEPS_LIGHT_APART
// For methods that keep light apart from its shadow: what chooses the light of first vertices, in place of the path's own
// number, and whether they have taken a light sample, with a shadow ray of their own.
float walk_light_number();
bool walk_keeps_apart(EyePath path, Ray ray, LightSample light_sample, vec3 radiance);
#endif

/// Follows the path's ray to the next vertex: adds what it finds there to `light`, with one light sample that competes
/// with WALK_COMPETING_RAYS, and draws the next ray by the specular part. False: the path ends; `met.waits` holds all
/// the same.
bool walk_vertex(uint vertex, uint key, float glossy_threshold, inout EyePath path, inout Ray ray, inout PathLight light,
                 inout uint shadow_rays, out WalkVertex met) {
    Bsdf specular;
    if (!walk_meet(vertex, glossy_threshold, path, ray, light, met, specular)) return false;
    const vec2 choice = sample_2d(key, sample_set(vertex, SET_LIGHT_CHOICE_AND_ROULETTE));
    if (bsdf_has_non_delta(specular) || bsdf_has_non_delta(met.rough)) {
        Ray to_light;
        vec3 radiance;
        LightSample light_sample;
        const vec2 u_light = sample_2d(key, sample_set(vertex, SET_LIGHT_POINT));
        float u_choice = choice.x;
#ifdef WALK_KEEPS_LIGHT_APART
        if (vertex == 0) u_choice = walk_light_number();
#endif
        if (walk_light_sample(path, met, specular, 1.0, WALK_COMPETING_RAYS, u_choice, u_light, to_light, radiance,
                              light_sample)) {
            uint seen = WALK_LIGHT_SEEN(met.surface.position, met.surface.geometric_normal, light_sample.source, key);
#ifdef WALK_KEEPS_LIGHT_APART
            if (vertex == 0 && walk_keeps_apart(path, to_light, light_sample, radiance)) {
                ++shadow_rays;
                seen = LIGHT_SEEN_NOTHING;
            }
#endif
            bool arrives = seen == LIGHT_SEEN_WHOLE;
            if (seen == LIGHT_SEEN_UNKNOWN) {
                ++shadow_rays;
                arrives = !occluded(to_light);
            }
            if (arrives) {
                if (path.scatterings == 0) light.direct += radiance; else light.indirect += radiance;
            }
        }
    }
    return walk_leave(vertex, key, met, specular, choice.y, path, light, ray);
}

#endif
