// Paths from the eye that end in cells, one thread a path. They have the bindings 0 to 7 of set 0. CPU twin:
// cached_paths.h; here a path has all lobes of the first surface too.
#ifndef PHOTOND_CACHED_PATHS_GLSL
#define PHOTOND_CACHED_PATHS_GLSL

#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#define CACHE_CONSTANTS_BINDING 4
#define CACHE_STATE_BINDING 5
#define CACHE_FINGERPRINTS_BINDING 6
#define CACHE_SUMS_BINDING 7
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/eye/eye_vertex.glsl"
#include "renderer/methods/radiance_cache/radiance_cells.glsl"

/// ray_spread_m() of the ray that has come so far.
float spread_of_ray(EyePath path, float distance_m) {
    return path.delta ? 0.0 : distance_m * inversesqrt(PI * path.pdf_sa);
}

/// Whether the cell of the vertex that the path has come to is asked and filled: CachedPaths::keeps_samples_at().
bool keeps_samples_at(EyePath path) {
    return path.scatterings > 0u && (cache.bounces_are_limited == 0u || path.scatterings == 1u);
}

/// cell_direction()
uint cell_direction(Bsdf rough, vec3 to_eye) {
    return bsdf_is_lambert(rough) || bsdf_is_diffuse(rough) ? 0u : 1u + direction_bin(to_eye, cache.direction_bins);
}

/// CachedPaths::ask(). False: no cell knows enough.
bool ask_cells(ShadingPoint surface, uint direction, uint finest, float spread_m, uint random, out vec3 radiance) {
    const vec2 u = vec2(to_unit_float(random), to_unit_float(hash32(random))) - 0.5;
    const Frame plane = make_frame(surface.geometric_normal);
    const uint coarser = coarser_levels(finest, spread_m);
    for (uint i = 0u; i <= coarser; ++i) {
        const vec3 beside = to_world(plane, vec3(cell_side_m(finest - i) * u, 0.0));
        const CellKey key = cell_key(surface.position + beside, surface.shading.normal, direction, finest - i);
        if (cell_mean(key, radiance) >= cache.least_samples) return true;
    }
    radiance = vec3(0.0);
    return false;
}

/// A light sample at a vertex, over what it is multiplied by; `wanted`: its shadow ray met nothing.
struct VertexLight {
    vec3 wi;  // local
    vec3 arrives;
    bool wanted;
};

VertexLight light_at_vertex(EyePath path, EyeVertex met, Bsdf bsdf, uint key, uint vertex, float u_choice,
                            inout uint shadow_rays) {
    VertexLight at = VertexLight(vec3(0.0), vec3(0.0), false);
    if (!bsdf_has_non_delta(bsdf)) return at;
    LightSample light_sample;
    const vec2 u = sample_2d(key, sample_set(vertex, SET_LIGHT_POINT));
    if (!sample_light(path.position, path.lit_normal, u_choice, u, light_sample)) return at;
    at.wi = to_local(met.surface.shading, light_sample.wi);
    const BsdfValue f = bsdf_evaluate(bsdf, met.wo, at.wi, TRANSPORT_RADIANCE);
    if (is_black(f.f_cos)) return at;
    ++shadow_rays;
    at.arrives = (light_sample.delta ? 1.0 : power_heuristic(light_sample.pdf_sa, f.pdf_sa)) * light_sample.radiance_over_pdf;
    at.wanted = !occluded(shadow_ray(light_sample, ray_origin(met.surface, light_sample.wi)));
    return at;
}

BsdfSample next_of_vertex(EyeVertex met, Bsdf bsdf, uint key, uint vertex) {
    const float u_lobe = ONLY_LAMBERT ? 0.0 : sample_2d(key, sample_set(vertex, SET_LOBE)).x;
    return bsdf_sample(bsdf, met.wo, u_lobe, sample_2d(key, sample_set(vertex, SET_DIRECTION)));
}

#endif
