#version 460
// Light from the voxels that a point counts as visible, a thread a point [Chen 2014, section 3.3]: what the four lists
// about it have, each by its weight; near voxels proxy by proxy, far ones as if all their light came from its middle.
// With PROXY_VISIBILITY_RAYS every voxel is asked by a shadow ray instead, to a proxy drawn by what it brings: unbiased.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/frame/device_image_shared.h"
#include "renderer/gbuffer/receiver.glsl"
#include "renderer/many_lights/vpl.glsl"
#include "renderer/methods/visibility_filtering/proxy_voxel.glsl"
#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"

layout(constant_id = PROXY_VISIBILITY_ID) const uint PROXY_VISIBILITY = PROXY_VISIBILITY_DISCS;
layout(constant_id = LISTS_ID) const uint LISTS = LISTS_COUNTS;
layout(constant_id = PAPER_SPECULAR_ID) const bool PAPER_SPECULAR = false;
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
        found.words[i] = list * constants.list_words;
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

/// Of the lists' light, how much counts of a voxel whose shares in them are these.
float share_of(NearLists about, vec4 shares) {
    float sum = 0.0, count = 0.0;
    for (int i = 0; i < 4; ++i) {
        sum += about.weights[i] * shares[i];
        if (about.weights[i] > 0.0) count += 1.0;
    }
    return PAPER_NORMALISATION ? sum / max(count, 1.0) : sum / about.total;
}

/// What a point scatters by: the wide lobe, and the narrower ones, which look at few voxels.
struct Lobes {
    Frame shading;
    vec3 wo;  // local
    Bsdf diffuse;
    Bsdf glossy;
    bool shines;
};

Lobes lobes_of(Receiver receiver) {
    const float all_gloss = 2.0;  // above every alpha
    Lobes lobes = Lobes(receiver.surface.shading, receiver.wo, bsdf_rough_part(receiver.rough, all_gloss),
                        bsdf_specular_part(receiver.rough, all_gloss), false);
    lobes.shines = bsdf_scatters(lobes.glossy);
    return lobes;
}

/// What surfaces bring to a point if nothing stands between: irradiance of Lambert points, of others radiance before the
/// throughput; and the shares of rays, drawn by the lobes, that would meet them then.
struct Brought {
    vec3 light;
    vec2 taken;  // by what has light, and by what has none
    vec3 gloss;
    vec2 gloss_taken;
};
const Brought NOTHING_BROUGHT = Brought(vec3(0.0), vec2(0.0), vec3(0.0), vec2(0.0));

/// `shares`: how much counts of what has light, and of what has none.
void add_brought(inout Brought sum, vec2 shares, Brought one) {
    sum.light += shares.x * one.light;
    sum.taken += shares * one.taken;
    sum.gloss += shares.x * one.gloss;
    sum.gloss_taken += shares * one.gloss_taken;
}

/// The paper's weight of a direction off the mirrored one by that cosine, in place of GGX [Chen 2014, equation 7]: eta is
/// Phong's exponent of the same width.
float paper_weight(float cosine, float alpha) {
    const float eta = max(2.0 / sqr(alpha) - 2.0, 1.0), sigma = 1.0 / 3.0;
    return exp(-0.5 * sqr((1.0 - pow(max(cosine, 0.0), eta)) / sigma)) / (sigma * sqrt(2.0 * PI));
}
BsdfValue glossy_value(Lobes lobes, vec3 wi) {
    if (!PAPER_SPECULAR) return bsdf_evaluate(lobes.glossy, lobes.wo, wi);
    const float weight = paper_weight(dot(wi, vec3(-lobes.wo.xy, lobes.wo.z)), lobes.glossy.alpha);
    return BsdfValue(weight * bsdf_albedo(lobes.glossy), weight);
}

/// From surfaces in the direction `to_light` that have areas with light and without, and send `power_w`, all times the
/// cosine there.
Brought bring(GBufferPoint point, Lobes lobes, vec3 to_light, float falloff, vec2 areas_m2, vec3 power_w) {
    Brought one = NOTHING_BROUGHT;
    const vec3 radiance = INV_PI * falloff * power_w;  // times the solid angle
    const vec2 solid_angles = falloff * areas_m2;
    const bool both_sides = !ONLY_LAMBERT && point.normal == vec3(0.0);
    const float cosine = both_sides ? 1.0 : max(dot(point.normal, to_light), 0.0);
    one.taken = INV_PI * cosine * solid_angles;
    if (!is_general(point)) {
        one.light = cosine * radiance;
        return one;
    }
    const vec3 wi = to_local(lobes.shading, to_light);
    if (!is_black(power_w)) one.light = radiance * bsdf_f_cos(lobes.diffuse, lobes.wo, wi);
    if (!lobes.shines) return one;
    const BsdfValue value = glossy_value(lobes, wi);
    one.gloss = radiance * value.f_cos;
    one.gloss_taken = value.pdf_sa * solid_angles;
    return one;
}
bool may_come_from(GBufferPoint point, vec3 to_light) {
    return (!ONLY_LAMBERT && point.normal == vec3(0.0)) ||
           (dot(point.normal, to_light) > 0.0 && dot(point.geometric_normal, to_light) > 0.0);
}

Brought proxy_light(uint proxy, GBufferPoint point, Lobes lobes) {
    const vec3 offset = uintBitsToFloat(grid_places[proxy].xyz) - point.position;
    const float distance_sq = dot(offset, offset);
    const vec3 to_light = offset * (1.0 / sqrt(max(distance_sq, 1e-37)));
    const float cos_o = -dot(proxy_normal(grid_places[proxy].w), to_light);
    const bool is_lit_one = proxy_is_lit(grid_places[proxy].w);
    if (!(cos_o > 0.0 || !is_lit_one) || grid_places[proxy].w == NO_PROXY || !may_come_from(point, to_light))
        return NOTHING_BROUGHT;
    return bring(point, lobes, to_light, abs(cos_o) / (distance_sq + constants.softening_sq_m2),
                 (is_lit_one ? vec2(1.0, 0.0) : vec2(0.0, 1.0)) / constants.proxies_per_m2,
                 uintBitsToFloat(map_powers[proxy].xyz));
}

/// By spherical harmonics of order 1, from the voxel's middle.
Brought far_light(ProxyVoxel voxel, vec3 to_light, float distance_sq, GBufferPoint point, Lobes lobes) {
    if (!may_come_from(point, to_light)) return NOTHING_BROUGHT;
    const vec3 along = -vec3(dot(voxel.flux_normal_w[0], to_light), dot(voxel.flux_normal_w[1], to_light),
                             dot(voxel.flux_normal_w[2], to_light));
    return bring(point, lobes, to_light, 1.0 / (distance_sq + constants.softening_sq_m2), area_seen(voxel, to_light),
                 max(0.25 * voxel.flux_w + 0.5 * along, vec3(0.0)));
}

bool proxy_is_seen(uint proxy, GBufferPoint point) {
    const vec3 position = uintBitsToFloat(grid_places[proxy].xyz), to_light = position - point.position;
    const vec3 side = dot(point.geometric_normal, to_light) > 0.0 ? point.geometric_normal : -point.geometric_normal;
    const vec3 origin = offset_ray_origin(point.position, side);
    const vec3 target = offset_ray_origin(position, proxy_normal(grid_places[proxy].w));
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

Brought voxel_light(uint index, GBufferPoint point, Lobes lobes) {
    const ProxyVoxel voxel = voxels[index];
    const bool asks = PROXY_VISIBILITY == PROXY_VISIBILITY_RAYS;
    uint random = hash32(point.pixel ^ hash32(index ^ constants.key));
    const vec3 offset = voxel.middle - point.position;
    const float distance_sq = dot(offset, offset);
    Brought sum = NOTHING_BROUGHT;
    uint chosen = voxel.first;
    if (distance_sq > sqr(constants.near_m)) {
        sum = far_light(voxel, offset * inversesqrt(distance_sq), distance_sq, point, lobes);
        if (asks) chosen = proxy_by_flux(voxel, to_unit_float(random));
    } else {
        float total = 0.0;
        for (uint proxy = voxel.first; proxy < voxel.end; ++proxy) {
            const Brought one = proxy_light(proxy, point, lobes);
            add_brought(sum, vec2(1.0), one);
            if (!asks) continue;
            const float share = mean(one.light + one.gloss);
            total += share;
            random = hash32(random);
            if (share > 0.0 && to_unit_float(random) * total < share) chosen = proxy;
        }
    }
    if (asks && !is_black(sum.light + sum.gloss) && !proxy_is_seen(chosen, point)) return NOTHING_BROUGHT;
    return sum;
}

/// Light of all lists. What narrow lobes see is few proxies: as the paper has it, their number counts for nothing.
vec3 light_of_sum(Brought sum) {
    if (!PAPER_SPECULAR) return sum.light + sum.gloss;
    const float taken = sum.gloss_taken.x + sum.gloss_taken.y;
    return sum.light + (taken > 0.0 ? sum.gloss / taken : vec3(0.0));
}

/// Of each voxel as much as rays say is seen of it. What all of them together would take up of the point's rays is known as
/// well, from the rays that met something: dividing by the one and multiplying by the other bounds the light by the
/// brightest voxel's radiosity, and gives back what is lost to voxels that no ray has met.
vec3 light_of_counts(NearLists about, GBufferPoint point, Lobes lobes) {
    Brought sum = NOTHING_BROUGHT;
    const uint last = constants.list_words - 1u;
    vec4 met = vec4(0.0);
    for (int i = 0; i < 4; ++i)
        if (about.weights[i] > 0.0) met[i] = uintBitsToFloat(lists[about.words[i] + last]);
    for (uint voxel = 0; voxel < last; ++voxel) {
        vec4 where_lit = vec4(0.0), where_dark = vec4(0.0);
        for (int i = 0; i < 4; ++i) {
            if (!(about.weights[i] > 0.0)) continue;
            const vec2 seen = unpackHalf2x16(lists[about.words[i] + voxel]);
            where_lit[i] = seen.x, where_dark[i] = seen.y;
        }
        const vec2 shares = vec2(share_of(about, where_lit), share_of(about, where_dark));
        if (shares != vec2(0.0)) add_brought(sum, shares, voxel_light(voxel, point, lobes));
    }
    const float all_met = share_of(about, met), least_taken = 0.25;  // of narrow lobes that look past everything
    const float taken = sum.taken.x + sum.taken.y, gloss_taken = sum.gloss_taken.x + sum.gloss_taken.y;
    vec3 light = taken > 0.0 ? sum.light * (all_met / taken) : vec3(0.0);
    if (lobes.shines) light += sum.gloss * (all_met / max(gloss_taken, least_taken));
    return light;
}

vec3 light_of_bits(NearLists about, GBufferPoint point, Lobes lobes) {
    Brought sum = NOTHING_BROUGHT;
    for (uint word = 0; word < constants.words; ++word) {
        uvec4 have = uvec4(0u);
        for (int i = 0; i < 4; ++i)
            if (about.weights[i] > 0.0) have[i] = lists[about.words[i] + word];
        for (uint bits = have.x | have.y | have.z | have.w; bits != 0u; bits &= bits - 1u) {
            const uint bit = uint(findLSB(bits));
            add_brought(sum, vec2(share_of(about, vec4(have >> bit & 1u))), voxel_light(32u * word + bit, point, lobes));
        }
    }
    return light_of_sum(sum);
}

/// List by list.
vec3 light_of_indices(NearLists about, GBufferPoint point, Lobes lobes) {
    Brought sum = NOTHING_BROUGHT;
    for (int i = 0; i < 4; ++i) {
        if (!(about.weights[i] > 0.0)) continue;
        vec4 shares = vec4(0.0);
        shares[i] = 1.0;
        const float share = share_of(about, shares);
        const uint count = lists[about.words[i]];
        for (uint k = 0; k < count; ++k)
            add_brought(sum, vec2(share), voxel_light(lists[about.words[i] + 1u + k], point, lobes));
    }
    return light_of_sum(sum);
}

vec3 light_of_lists(NearLists about, GBufferPoint point, Lobes lobes) {
    if (!(about.total > 0.0)) return vec3(0.0);
    if (LISTS == LISTS_COUNTS) return light_of_counts(about, point, lobes);
    if (LISTS == LISTS_BITS) return light_of_bits(about, point, lobes);
    return light_of_indices(about, point, lobes);
}

vec3 light_of_all(GBufferPoint point, Lobes lobes) {
    Brought sum = NOTHING_BROUGHT;
    for (uint word = 0; word < constants.words; ++word)
        for (uint bits = lists[word]; bits != 0u; bits &= bits - 1u)
            add_brought(sum, vec2(1.0), voxel_light(32u * word + uint(findLSB(bits)), point, lobes));
    return light_of_sum(sum);
}

void main() {
    const uint index = push.first + flat_index();
    if (index >= push.end) return;
    const uint pixel = split_pixel_of(constants.split, index);
    if (pixel == NO_PIXEL) return;
    const GBufferPoint point = points[index];
    const uint x = pixel % constants.split.width, y = pixel / constants.split.width;
    if (!lights_itself(constants.split, x, y, point, agreeing_height_m(point))) return;
    Lobes lobes;
    lobes.shines = false;
    if (is_general(point)) lobes = lobes_of(make_receiver(general_points[index], constants.glossy_threshold));
    if (PROXY_VISIBILITY == PROXY_VISIBILITY_RAYS)
        sums[index] = light_of_all(point, lobes);
    else
        sums[index] = light_of_lists(lists_about(x, y, point), point, lobes);
}
