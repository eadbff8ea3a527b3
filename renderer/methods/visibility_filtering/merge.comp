#version 460
// Indirect light into the image, a thread a pixel: a pixel's own, or what those about it have; and looks at proxies, voxels
// and lists.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/frame/device_image.glsl"
#include "renderer/methods/visibility_filtering/proxy_voxel.glsl"
#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/gbuffer/upsampling_shared.h"
#include "renderer/photons/hash_grid.glsl"

layout(constant_id = LISTS_ID) const uint LISTS = LISTS_COUNTS;

layout(local_size_x = LISTS_GROUP) in;
layout(set = 0, binding = 1, scalar) readonly buffer Constants { VisibilityConstants constants; };
layout(set = 0, binding = 2, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Sums { vec3 sums[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Lists { uint lists[]; };
layout(set = 0, binding = 5, scalar) readonly buffer Filtered { uint filtered[]; };
layout(set = 0, binding = 6, scalar) readonly buffer GridStarts { uint grid_starts[]; };
layout(set = 0, binding = 7, std430) readonly buffer GridPlaces { uvec4 grid_places[]; };
layout(set = 0, binding = 8, std430) readonly buffer MapPowers { uvec4 map_powers[]; };
layout(set = 0, binding = 9, scalar) readonly buffer LitWords { uint lit_words[]; };
#define VISIBILITY constants
#include "renderer/methods/visibility_filtering/marching_points.glsl"
#define SUB_POINTS points
#define SUB_SUMS sums
#include "renderer/gbuffer/upsampling.glsl"

/// The radiosity of the nearest proxy whose disc a place lies on.
vec3 proxy_at(vec3 position, uint slot) {
    const float radius_m = constants.disc_radius_m;
    float nearest_sq = sqr(radius_m);
    vec3 radiosity = vec3(0.0);
    const uint end = grid_starts[constants.grid.first_start + slot + 1];
    for (uint i = grid_starts[constants.grid.first_start + slot]; i < end; ++i) {
        const vec3 offset = position - uintBitsToFloat(grid_places[i].xyz);
        if (!(dot(offset, offset) < nearest_sq) || grid_places[i].w == NO_PROXY) continue;
        if (abs(dot(offset, proxy_normal(grid_places[i].w))) > 0.1 * radius_m) continue;
        nearest_sq = dot(offset, offset);
        radiosity = constants.proxies_per_m2 * uintBitsToFloat(map_powers[i].xyz);
    }
    return radiosity;
}

bool is_met(uint list, uint slot) {
    const uint first = list * constants.words;
    return LISTS == LISTS_COUNTS ? lists[first + 2u * slot] != 0u
                                 : (lists[first + slot / 32u] >> slot % 32u & 1u) != 0u;
}
bool is_seen(uint list, uint slot) {
    const uint first = list * constants.list_words;
    return LISTS == LISTS_COUNTS ? filtered[first + slot] != 0u
                                 : (filtered[first + slot / 32u] >> slot % 32u & 1u) != 0u;
}

void show_structures(uint pixel, uint x, uint y, GBufferPoint point) {
    const uint slot = grid_slot_of(constants.grid, point.position);
    if (layer_kept(LAYER_PROXIES)) store_rgb(LAYER_PROXIES, pixel, proxy_at(point.position, slot));
    if (layer_kept(LAYER_PROXY_VOXELS)) {
        const uint color = hash32(slot);
        store_rgb(LAYER_PROXY_VOXELS, pixel, vec3(color & 0xffu, color >> 8 & 0xffu, color >> 16 & 0xffu) / 255.0);
    }
    if (LISTS == LISTS_NONE) return;
    if (!layer_kept(LAYER_VISIBILITY_COUNT) && !layer_kept(LAYER_LISTS_BEFORE_FILTER)) return;
    const uint column = min(x / constants.march_side, constants.march_columns - 1u);
    const uint row = min(y / constants.march_side, constants.march_rows - 1u);
    const uint list = row * constants.march_columns + column;
    uint seen = 0, before = 0;
    for (uint slot = 0; slot < constants.grid.slots; ++slot) {
        if ((lit_words[slot / 32u] >> slot % 32u & 1u) == 0u) continue;
        if (is_met(list, slot)) ++before;
        if (LISTS != LISTS_INDICES && is_seen(list, slot)) ++seen;
    }
    if (LISTS == LISTS_INDICES) seen = filtered[list * constants.list_words];
    if (layer_kept(LAYER_VISIBILITY_COUNT)) store_value(LAYER_VISIBILITY_COUNT, pixel, float(seen));
    if (layer_kept(LAYER_LISTS_BEFORE_FILTER)) store_value(LAYER_LISTS_BEFORE_FILTER, pixel, float(before));
}

void main() {
    const SplitRecord split = constants.split;
    const uint pixel = flat_index();
    uint x, y, index;
    if (!split_place_of(split, pixel, x, y, index)) return;
    const GBufferPoint point = points[index];
    if (point.kind == 0u) return;
    const float height_m = agreeing_height_m(point);
    vec3 light = sums[index];
    if (is_lit(point) && !lights_itself(split, x, y, point, height_m)) {
        const SubSamples from = sub_samples_of(split, x, y, point, height_m);
        light = light_of_sub_samples(from);
        if (layer_kept(LAYER_UPSAMPLING_WEIGHT)) store_value(LAYER_UPSAMPLING_WEIGHT, pixel, from.total);
    }
    add_rgb(LAYER_INDIRECT, pixel, point.weight * light);
    show_structures(pixel, x, y, point);
}
