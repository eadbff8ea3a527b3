#version 460
// Light from the voxels that a point counts as visible, a thread a point [Chen 2014, section 3.3]: what the four lists
// about it have, each by its weight; near voxels proxy by proxy, far ones as if all their light came from its centroid.
// With PROXY_VISIBILITY_RAYS every voxel is asked by a shadow ray instead, to a proxy drawn by what it brings: unbiased.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/frame/device_image_shared.h"
#include "renderer/gbuffer/receiver.glsl"
#include "renderer/many_lights/vpl.glsl"
#include "renderer/methods/visibility_filtering/point_proxies_shared.h"
#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"
#include "renderer/photons/photon.glsl"

layout(constant_id = PROXY_VISIBILITY_ID) const uint PROXY_VISIBILITY = PROXY_VISIBILITY_DISCS;
layout(constant_id = PAPER_NORMALISATION_ID) const bool PAPER_NORMALISATION = false;

layout(local_size_x = LISTS_GROUP) in;
layout(push_constant, scalar) uniform Push { ListsPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { VisibilityConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 3, std430) readonly buffer GridPlaces { uvec4 grid_places[]; };
layout(set = 0, binding = 4, std430) readonly buffer MapPowers { uvec4 map_powers[]; };
layout(set = 0, binding = 5, scalar) readonly buffer Voxels { ProxyVoxel voxels[]; };
layout(set = 0, binding = 6, scalar) readonly buffer Lists { uint lists[]; };  // one, of all lit voxels, for rays
layout(set = 0, binding = 7, scalar) readonly buffer RunningSums { float running_sums[]; };
layout(set = 0, binding = 8, scalar) writeonly buffer Sums { vec3 sums[]; };
#define COUNTERS_BINDING 9
#include "renderer/backends/gpu/counters.glsl"
#define VISIBILITY constants
#include "renderer/methods/visibility_filtering/marching_points.glsl"
#define SUB_POINTS points
#include "renderer/gbuffer/upsampling.glsl"

/// The four lists about a pixel.
struct NearLists {
    uint words[4];  // where they begin
    float weights[4];
    float total;
};

NearLists lists_about(uint x, uint y, GBufferPoint point) {
    NearLists found;
    const ivec2 size = ivec2(constants.march_columns, constants.march_rows);
    const vec2 place = (vec2(x, y) - float(marching_offset())) / float(constants.march_side);
    const vec2 low = floor(place), part = place - low;
    float near[4], near_total = 0.0;
    found.total = 0.0;
    for (int i = 0; i < 4; ++i) {
        const ivec2 corner = ivec2(i % 2, i / 2), at = clamp(ivec2(low) + corner, ivec2(0), size - 1);
        const vec2 share = mix(1.0 - part, part, vec2(corner));
        const uint list = uint(at.y * size.x + at.x);
        const GBufferPoint other = points[marching_point(list)];
        found.words[i] = list * constants.words;
        near[i] = is_lit(other) ? share.x * share.y : 0.0;
        const float height_m = dot(point.geometric_normal, other.position - point.position);
        found.weights[i] = near[i] * max(dot(other.geometric_normal, point.geometric_normal), 0.0) *
                           exp(-sqr(height_m / agreeing_height_m(point)));
        near_total += near[i];
        found.total += found.weights[i];
    }
    if (found.total < 1e-3) {  // none lies on the point's surface
        found.weights = near;
        found.total = near_total;
    }
    return found;
}

/// Of the lists' light, how much counts of a voxel that those with `has` have.
float share_of(NearLists about, bvec4 has) {
    float sum = 0.0, count = 0.0;
    for (int i = 0; i < 4; ++i) {
        if (has[i]) sum += about.weights[i];
        if (about.weights[i] > 0.0) count += 1.0;
    }
    return PAPER_NORMALISATION ? sum / max(count, 1.0) : sum / about.total;
}

/// What a direction brings to a point of an intensity over the squared distance: irradiance of Lambert points, of others
/// radiance before the throughput.
vec3 brings(GBufferPoint point, Receiver receiver, vec3 to_light, vec3 perpendicular) {
    if (is_general(point))
        return perpendicular * bsdf_f_cos(receiver.rough, receiver.wo, to_local(receiver.surface.shading, to_light));
    return perpendicular * max(dot(point.normal, to_light), 0.0);
}
bool may_come_from(GBufferPoint point, vec3 to_light) {
    return (!ONLY_LAMBERT && point.normal == vec3(0.0)) ||
           (dot(point.normal, to_light) > 0.0 && dot(point.geometric_normal, to_light) > 0.0);
}

vec3 proxy_light(uint proxy, GBufferPoint point, Receiver receiver) {
    const vec3 offset = uintBitsToFloat(grid_places[proxy].xyz) - point.position;
    const float distance_sq = dot(offset, offset);
    const vec3 to_light = offset * (1.0 / sqrt(max(distance_sq, 1e-37)));
    const float cos_o = -dot(octahedral_decode(16u, grid_places[proxy].w), to_light);
    if (!(cos_o > 0.0) || !may_come_from(point, to_light)) return vec3(0.0);
    const float gain = INV_PI * cos_o / (distance_sq + constants.softening_sq_m2);
    return brings(point, receiver, to_light, gain * uintBitsToFloat(map_powers[proxy].xyz));
}

/// By spherical harmonics of order 1, from the centroid.
vec3 far_light(ProxyVoxel voxel, vec3 to_light, float distance_sq, GBufferPoint point, Receiver receiver) {
    if (!may_come_from(point, to_light)) return vec3(0.0);
    const vec3 along = -vec3(dot(voxel.flux_normal_w[0], to_light), dot(voxel.flux_normal_w[1], to_light),
                             dot(voxel.flux_normal_w[2], to_light));
    const vec3 intensity = max(INV_PI * (0.25 * voxel.flux_w + 0.5 * along), vec3(0.0));
    return brings(point, receiver, to_light, intensity / (distance_sq + constants.softening_sq_m2));
}

bool proxy_is_seen(uint proxy, GBufferPoint point) {
    const vec3 position = uintBitsToFloat(grid_places[proxy].xyz), to_light = position - point.position;
    const vec3 side = dot(point.geometric_normal, to_light) > 0.0 ? point.geometric_normal : -point.geometric_normal;
    const vec3 origin = offset_ray_origin(point.position, side);
    const vec3 target = offset_ray_origin(position, octahedral_decode(16u, grid_places[proxy].w));
    count(COUNTER_SHADOW_RAYS, 1);
    return !occluded(Ray(origin, target - origin, kConnectionEnd));
}

/// A proxy of the voxel in proportion to its flux.
uint proxy_by_flux(ProxyVoxel voxel, float u) {
    const float wanted = u * running_sums[voxel.end - 1u];
    uint low = voxel.first, high = voxel.end - 1u;  // the first whose sum is above is in [low, high]
    while (low < high) {
        const uint middle = (low + high) / 2u;
        if (running_sums[middle] > wanted) high = middle; else low = middle + 1u;
    }
    return low;
}

vec3 voxel_light(uint index, GBufferPoint point, Receiver receiver) {
    const ProxyVoxel voxel = voxels[index];
    const bool asks = PROXY_VISIBILITY == PROXY_VISIBILITY_RAYS;
    uint random = hash32(point.pixel ^ hash32(index ^ constants.key));
    const vec3 offset = voxel.middle - point.position;
    const float distance_sq = dot(offset, offset);
    vec3 light = vec3(0.0);
    uint chosen = voxel.first;
    if (distance_sq > sqr(constants.near_m)) {
        light = far_light(voxel, offset * inversesqrt(distance_sq), distance_sq, point, receiver);
        if (asks) chosen = proxy_by_flux(voxel, to_unit_float(random));
    } else {
        float total = 0.0;
        for (uint proxy = voxel.first; proxy < voxel.end; ++proxy) {
            const vec3 one = proxy_light(proxy, point, receiver);
            light += one;
            if (!asks) continue;
            const float share = mean(one);
            total += share;
            random = hash32(random);
            if (share > 0.0 && to_unit_float(random) * total < share) chosen = proxy;
        }
    }
    if (!asks || is_black(light)) return light;
    return proxy_is_seen(chosen, point) ? light : vec3(0.0);
}

vec3 light_of_lists(NearLists about, GBufferPoint point, Receiver receiver) {
    vec3 light = vec3(0.0);
    if (!(about.total > 0.0)) return light;
    for (uint word = 0; word < constants.words; ++word) {
        uvec4 lists_have = uvec4(0u);
        for (int i = 0; i < 4; ++i)
            if (about.weights[i] > 0.0) lists_have[i] = lists[about.words[i] + word];
        for (uint bits = lists_have.x | lists_have.y | lists_have.z | lists_have.w; bits != 0u; bits &= bits - 1u) {
            const uint bit = uint(findLSB(bits));
            const bvec4 has = notEqual(lists_have & (1u << bit), uvec4(0u));
            light += share_of(about, has) * voxel_light(32u * word + bit, point, receiver);
        }
    }
    return light;
}

vec3 light_of_all(GBufferPoint point, Receiver receiver) {
    vec3 light = vec3(0.0);
    for (uint word = 0; word < constants.words; ++word)
        for (uint bits = lists[word]; bits != 0u; bits &= bits - 1u)
            light += voxel_light(32u * word + uint(findLSB(bits)), point, receiver);
    return light;
}

void main() {
    const uint index = push.first + flat_index();
    if (index >= push.end) return;
    const uint pixel = split_pixel_of(constants.split, index);
    if (pixel == NO_PIXEL) return;
    const GBufferPoint point = points[index];
    const uint x = pixel % constants.split.width, y = pixel / constants.split.width;
    if (!lights_itself(constants.split, x, y, point, agreeing_height_m(point))) return;
    Receiver receiver;
    if (is_general(point)) receiver = make_receiver(general_points[index], constants.glossy_threshold);
    if (PROXY_VISIBILITY == PROXY_VISIBILITY_RAYS)
        sums[index] = light_of_all(point, receiver);
    else
        sums[index] = light_of_lists(lists_about(x, y, point), point, receiver);
}
