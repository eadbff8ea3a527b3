#version 460
// The eye's side of a progressive pass, a thread a pixel: through what is specular (CPU twin: specular_walk.cpp), and at
// each visible point the maps' light on discs whose radii shrink from pass to pass (CPU twin: progressive_mapping.cpp).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define NEAREST_GROUP (EYE_TILE * EYE_TILE)
#define IMAGE_BINDING 0
#define COUNTERS_BINDING 1
#define EYE_BINDING 2
#define SAMPLER_BINDING 3
#define GRID_STARTS_BINDING 5
#define GRID_PLACES_BINDING 6
#define MAP_POWERS_BINDING 7
#define RADIUS_MAP_BINDING 8
#define POINTS_BEFORE_BINDING 9
#define POINTS_AFTER_BINDING 10
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/eye/eye_shared.h"
#include "renderer/eye/specular_walk.glsl"
#include "renderer/gathering/gathering_shared.h"
#include "renderer/progressive/progressive_shared.h"

layout(set = 0, binding = 4, scalar) readonly buffer Constants { ProgressiveConstants constants; };

#define PROGRESSIVE constants
#define ESTIMATE constants.estimate
#define COVERAGE constants.estimate.coverage
#define EDGE_WORD(index) grid_starts[index]  // behind those of the grids
#include "renderer/photons/hash_grid.glsl"
#include "renderer/progressive/point_radii.glsl"
#include "renderer/progressive/radius_map.glsl"

layout(constant_id = GLOBAL_MAP_ID) const bool GLOBAL_MAP = true;
layout(constant_id = CAUSTIC_MAP_ID) const bool CAUSTIC_MAP = true;

layout(local_size_x = EYE_TILE * EYE_TILE) in;
layout(push_constant, scalar) uniform Push { ProgressivePush push; };

/// What layers show of a pixel's discs.
struct DiscLayers {
    uint photons;
    float radius_m;  // the largest
    float bias;
};

bool has_map(uint kind) { return kind == PHOTON_MAP_GLOBAL ? GLOBAL_MAP : CAUSTIC_MAP; }

/// DiscRadii::radius_m().
float disc_radius_m(uint kind, uint pixel, vec3 position, uint turn) {
    if (POINTS_HAVE_RADII) return point_radius_m(kind, pixel, position);
    if (RADIUS_RULE == RADIUS_RULE_TRAINED)
        return constants.share *
               radius_by_map(constants.radii[kind].first_node, constants.radii[kind].first_leaf, position, turn);
    return constants.estimate.maps[kind].radius_m;
}

/// Light of the maps that a visible point scatters.
void look_up(WalkVertex met, uint pixel, uint turn, inout PathLight light, inout DiscLayers shown) {
    const uint most = photon_scatterings_left(met.scatterings + 1);
    if (most == 0) return;
    DiscQuery query = disc_query(turn, DISC_COARSE_BATCH);  // passes are averaged
    query.channels = LUMINANCE_WEIGHTS * met.throughput;
    for (uint kind = PHOTON_MAP_GLOBAL; kind <= PHOTON_MAP_CAUSTIC; ++kind) {
        if (!has_map(kind) || is_empty(constants.estimate.maps[kind].grid)) continue;
        query.radius_m = disc_radius_m(kind, pixel, met.surface.position, turn);
        const RadianceEstimate found = estimate_radiance(kind, met.surface, met.rough, met.wo, most, query);
        if (POINTS_HAVE_RADII) gather_point(kind, found.scattered);
        light.indirect += met.throughput * found.radiance;
        if (layer_kept(LAYER_CAUSTIC) && kind == PHOTON_MAP_CAUSTIC && met.scatterings == 0)
            light.caustic += met.throughput * found.delta_radiance;
        shown.photons += found.photons;
        shown.radius_m = max(shown.radius_m, query.radius_m);
        // In light that varies quadratically the constant kernel is 3 sum w t / (pi r^2) too bright.
        if (DISC_MOMENTS) shown.bias += constants.bias_factor * 3.0 * INV_PI * disc_moments.w_t / sqr(query.radius_m);
    }
}

void main() {
    EyePath path;
    Ray ray;
    uint key;
    const uint tile = push.first_tile + flat_index() / (EYE_TILE * EYE_TILE);
    if (!start_eye_path(tile, push.end_tile, gl_LocalInvocationIndex, path, ray, key)) return;
    const uint pixel = path.pixel;
    if (POINTS_HAVE_RADII) clear_pass_points();
    PathLight light = no_light();
    DiscLayers shown = DiscLayers(0u, 0.0, 0.0);
    uint vertices = 0, shadow_rays = 0;
    for (bool walking = true; walking; ++vertices) {
        WalkVertex met;
        walking = walk_vertex(vertices, key, constants.glossy_threshold, path, ray, light, shadow_rays, met);
        if (met.waits)
            look_up(met, pixel, disc_turn(sample_2d(key, sample_set(vertices, SET_DIRECTION))), light, shown);
    }
    if (POINTS_HAVE_RADII)
        for (uint kind = PHOTON_MAP_GLOBAL; kind <= PHOTON_MAP_CAUSTIC; ++kind)
            if (has_map(kind)) store_point(kind, pixel);
    store_light(pixel, light);
    if (layer_kept(LAYER_PHOTON_COUNT)) store_value(LAYER_PHOTON_COUNT, pixel, float(shown.photons));
    if (layer_kept(LAYER_RADIUS)) store_value(LAYER_RADIUS, pixel, shown.radius_m);
    if (layer_kept(LAYER_BIAS_ESTIMATE)) store_value(LAYER_BIAS_ESTIMATE, pixel, shown.bias);
    count(COUNTER_CAMERA_RAYS, 1);
    count(COUNTER_BOUNCE_RAYS, vertices - 1);
    count(COUNTER_SHADOW_RAYS, shadow_rays);
}
