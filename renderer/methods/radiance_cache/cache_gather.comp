#version 460
// Paths from the eye to where cells know enough, a thread a pixel.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/radiance_cache/cached_paths.glsl"

layout(local_size_x = EYE_TILE * EYE_TILE) in;
layout(push_constant, scalar) uniform Push { CacheGatherPush push; };

uint hits = 0, misses = 0, shadow_rays = 0;

/// The cell of the first surface, as the layers show it.
void show_cell(uint pixel, ShadingPoint surface, Bsdf rough, vec3 to_eye) {
    uint level;
    if (!cell_level(distance(surface.position, cache.eye), INFINITY, level)) return;
    const CellKey key = cell_key(surface.position, surface.shading.normal, cell_direction(rough, to_eye), level);
    vec3 radiance;
    if (layer_kept(LAYER_CACHE_SAMPLES)) store_value(LAYER_CACHE_SAMPLES, pixel, float(cell_mean(key, radiance)));
    if (layer_kept(LAYER_CACHE_CELLS))
        store_rgb(LAYER_CACHE_CELLS, pixel, vec3(to_unit_float(hash32(key.fingerprint)),
                                                 to_unit_float(hash32(key.fingerprint + 1u)),
                                                 to_unit_float(hash32(key.fingerprint + 2u))));
}

/// What the cell of the vertex knows is added to `light`, and the rough part taken from `bsdf`. False: the path ends there.
bool end_in_cell(EyePath path, EyeVertex met, Bsdf rough, vec3 to_eye, float spread_m, uint random, inout Bsdf bsdf,
                 inout PathLight light) {
    uint level;
    vec3 known;
    if (!cell_level(distance(met.surface.position, cache.eye), spread_m, level)) return true;
    if (!ask_cells(met.surface, cell_direction(rough, to_eye), level, spread_m, random, known)) {
        ++misses;
        return true;
    }
    ++hits;
    light.indirect += path.throughput * bsdf_albedo(rough) * known;
    if (bsdf_is_lambert(bsdf)) return false;
    bsdf = bsdf_specular_part(bsdf, cache.glossy_threshold);
    return bsdf_scatters(bsdf);
}

/// A vertex of the path. False: it ends.
bool step_path(uint vertex, uint key, inout float spread_m, inout EyePath path, inout Ray ray, inout PathLight light) {
    const Hit hit = closest_hit(ray);
    if (!arrive(path, hit, ray, light)) return false;
    EyeVertex met;
    if (!meet_surface(path, vertex, hit, ray, light, met)) return false;
    if (path.scatterings > 0u) spread_m += spread_of_ray(path, hit.t);
    Bsdf bsdf = met.bsdf;
    const Bsdf rough = bsdf_is_lambert(bsdf) ? bsdf : bsdf_rough_part(bsdf, cache.glossy_threshold);
    if (push.asks_cells != 0u && bsdf_scatters(rough)) {
        if (push.shows_cells != 0u && path.scatterings == 0u) show_cell(path.pixel, met.surface, rough, -ray.direction);
        const uint random = hash32(key ^ hash32(cache.key ^ vertex));
        if (keeps_samples_at(path) && !end_in_cell(path, met, rough, -ray.direction, spread_m, random, bsdf, light))
            return false;
    }
    const vec2 choice = sample_2d(key, sample_set(vertex, SET_LIGHT_CHOICE_AND_ROULETTE));
    const VertexLight lit = light_at_vertex(path, met, bsdf, key, vertex, choice.x, shadow_rays);
    if (lit.wanted) {
        const vec3 radiance = path.throughput * lit.arrives * bsdf_f_cos(bsdf, met.wo, lit.wi);
        if (path.scatterings == 0u) light.direct += radiance; else light.indirect += radiance;
    }
    return leave_surface(path, met.surface, next_of_vertex(met, bsdf, key, vertex), vertex + 1u >= eye.roulette_start,
                         choice.y, light, ray);
}

void light_pixel(EyePath path, Ray ray, uint key) {
    const uint pixel = path.pixel;
    PathLight light = no_light();
    float spread_m = 0.0;
    uint vertices = 1;
    for (; step_path(vertices - 1u, key, spread_m, path, ray, light); ++vertices) {}
    light.emitted *= push.share, light.direct *= push.share;
    light.indirect *= push.share, light.caustic *= push.share;
    store_light(pixel, light);
    count_in_cache(CACHE_HITS, hits);
    count_in_cache(CACHE_MISSES, misses);
    count(COUNTER_SHADOW_RAYS, shadow_rays);
    count(COUNTER_BOUNCE_RAYS, vertices - 1u);
    count(COUNTER_CAMERA_RAYS, 1);
}

void main() {
    const uint tile = push.first_tile + flat_index() / (EYE_TILE * EYE_TILE);
    uint key;
    EyePath path;
    Ray ray;
    if (start_eye_path(tile, push.end_tile, gl_LocalInvocationIndex, path, ray, key)) light_pixel(path, ray, key);
}
