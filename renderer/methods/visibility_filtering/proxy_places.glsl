// The body of proxy_places.comp and proxy_places_depth_maps.comp: proxies on their triangles and the light that reaches
// them, a thread a proxy, by a light sample, so that lights of every kind count. What a proxy sends on is the light that
// its surface's rough lobes reflect. Before it come #version, the extensions and PROXY_LIGHT_SEEN(position, normal,
// source): a LIGHT_SEEN_* of a light source; where nothing is known its shadow ray is traced.

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/flux_map.glsl"
#include "renderer/methods/visibility_filtering/proxy_placement_shared.h"
#include "renderer/methods/visibility_filtering/proxy_voxel.glsl"
#include "renderer/transport/bsdf_material.glsl"
#include "renderer/transport/light_sampling.glsl"

layout(local_size_x = PROXY_GROUP) in;
layout(push_constant, scalar) uniform Push { ProxyPush push; };
layout(set = 0, binding = 0, scalar) buffer State { uint state[PROXY_STATE_WORDS]; };
layout(set = 0, binding = 2, scalar) readonly buffer Starts { uint starts[]; };  // by triangle: its first proxy
layout(set = 0, binding = 3, std430) writeonly buffer Places { uvec4 places[]; };
layout(set = 0, binding = 4, std430) writeonly buffer Powers { uvec4 powers[]; };
layout(set = 0, binding = 5, scalar) writeonly buffer Order { uint order[]; };
#define SVO_FIRST_TRIANGLES_BINDING 1
#define PROXY_PUSH push
#include "renderer/methods/visibility_filtering/proxy_triangles.glsl"
#define COUNTERS_BINDING 6
#include "renderer/backends/gpu/counters.glsl"

/// The triangle that has the proxy: the last one that begins at or before it.
uint triangle_of(uint proxy) {
    uint low = 0u, high = state[PROXY_TRIANGLES_WORD];
    while (high - low > 1u) {
        const uint middle = (low + high) / 2u;
        if (starts[middle] <= proxy) low = middle; else high = middle;
    }
    return low;
}

/// The side of a surface that a light sample reaches, and what it sends on, of a square metre: W.
struct LitSide {
    ShadingPoint point;
    vec3 radiosity;
};

bool light_side(Hit hit, vec3 face, inout RandomStream random, out LitSide side) {
    side.point = make_shading_point(hit, -face);
    side.radiosity = vec3(0.0);
    LightSample light_sample;
    const float u_choice = random_stream_next(random);
    if (!sample_light(side.point.position, vec3(0.0), u_choice, random_stream_next_2d(random), light_sample)) return false;
    if (dot(light_sample.wi, face) < 0.0) side.point = make_shading_point(hit, face);
    const float cosine = dot(light_sample.wi, side.point.shading.normal);
    if (!(cosine > 0.0 && dot(light_sample.wi, side.point.geometric_normal) > 0.0)) return false;
    if (NEEDS_UNLIT && has_flag(scene_materials[side.point.material].flags, MATERIAL_UNLIT)) return false;
    const vec3 albedo = bsdf_albedo(bsdf_rough_part(make_bsdf(side.point), push.glossy_threshold));
    side.radiosity = albedo * cosine * light_sample.radiance_over_pdf;
    if (is_black(side.radiosity)) return false;
    const uint seen = PROXY_LIGHT_SEEN(side.point.position, side.point.geometric_normal, light_sample.source);
    if (seen == LIGHT_SEEN_NOTHING) side.radiosity = vec3(0.0);
    if (seen != LIGHT_SEEN_UNKNOWN) return true;
    count(COUNTER_SHADOW_RAYS, 1);
    if (occluded(shadow_ray(light_sample, ray_origin(side.point, light_sample.wi)))) side.radiosity = vec3(0.0);
    return true;
}

void main() {
    const uint proxy = push.first_proxy + flat_index();
    if (proxy >= min(state[PROXIES_WORD], push.capacity)) return;
    const uint number = triangle_of(proxy);
    const uvec2 which = svo_triangle(number, push.instances);
    const TriangleCorners at = world_triangle(which.x, which.y);
    const uint key = hash32(proxy_key(at) + 1u), own = proxy - starts[number];
    const uvec2 point = rotated_halton_point(own, uvec2(key, hash32(key)));
    const vec2 st = sample_triangle(vec2(to_unit_float(point.x), to_unit_float(point.y)));
    const Hit hit = Hit(0.0, which.x, which.y, st.x, st.y);
    vec3 face = unit_cross(at.p[1] - at.p[0], at.p[2] - at.p[0]);
    if (flips_orientation(which.x)) face = -face;
    RandomStream random = make_random_stream(push.seed, RANDOM_DOMAIN_PROXIES, push.pass,
                                             uint64_t(number) << 32 | uint64_t(own));
    const bool there = random_stream_next(random) < surface_coverage(which.x, which.y, st.x, st.y);
    LitSide side;
    light_side(hit, face, random, side);
    if (!is_finite(side.radiosity)) {
        atomicAdd(state[PROXY_NAN_WORD], 1u);
        side.radiosity = vec3(0.0);
    }
    places[proxy] = uvec4(floatBitsToUint(side.point.position),
                          there ? proxy_word(side.point.geometric_normal, !is_black(side.radiosity)) : NO_PROXY);
    powers[proxy] = uvec4(floatBitsToUint(there ? side.radiosity / push.per_m2 : vec3(0.0)), 0u);
    order[proxy] = proxy;
}
