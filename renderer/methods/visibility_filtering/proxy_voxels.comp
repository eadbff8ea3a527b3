#version 460
// Light of each voxel's proxies, a group a voxel: its flux, the flux times the normals (spherical harmonics of order 1
// are these but for a factor [Chen 2014, equations 2 and 3]), its centroid, and the running sum that a proxy is chosen by.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/core/geometry.glsl"
#include "renderer/methods/visibility_filtering/proxy_voxel.glsl"

layout(local_size_x = PROXY_GROUP) in;
layout(push_constant, scalar) uniform Push { ProxyVoxelsPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer GridStarts { uint grid_starts[]; };
layout(set = 0, binding = 1, std430) readonly buffer GridPlaces { uvec4 grid_places[]; };
layout(set = 0, binding = 2, std430) readonly buffer Powers { uvec4 powers[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Voxels { ProxyVoxel voxels[]; };
layout(set = 0, binding = 4, scalar) buffer LitWords { uint lit_words[]; };  // a bit a voxel
layout(set = 0, binding = 5, scalar) writeonly buffer RunningSums { float running_sums[]; };  // of mean flux, in a voxel

shared vec4 sums[PROXY_GROUP];

/// Of all threads; always in the same order.
vec4 sum_of_group(vec4 mine) {
    const uint thread = gl_LocalInvocationIndex;
    sums[thread] = mine;
    barrier();
    for (uint step = PROXY_GROUP / 2; step > 0; step /= 2) {
        if (thread < step) sums[thread] += sums[thread + step];
        barrier();
    }
    const vec4 sum = sums[0];
    barrier();
    return sum;
}

/// Of the threads up to this one.
float running_sum_of_group(float mine) {
    const uint thread = gl_LocalInvocationIndex;
    float sum = mine;
    sums[thread].x = sum;
    barrier();
    for (uint step = 1; step < PROXY_GROUP; step *= 2) {
        const float before = thread >= step ? sums[thread - step].x : 0.0;
        barrier();
        sum += before;
        sums[thread].x = sum;
        barrier();
    }
    return sum;
}

void main() {
    const uint voxel = flat_index() / PROXY_GROUP, thread = gl_LocalInvocationIndex;
    if (voxel >= push.grid.slots) return;
    const uint first = grid_starts[push.grid.first_start + voxel], end = grid_starts[push.grid.first_start + voxel + 1];
    vec3 flux = vec3(0.0), normals[3] = vec3[](vec3(0.0), vec3(0.0), vec3(0.0));
    vec4 middle = vec4(0.0), place = vec4(0.0), lit = vec4(0.0);  // lit: number, and sum of normals
    float dark = 0.0;
    float before = 0.0;
    for (uint chunk = first; chunk < end; chunk += PROXY_GROUP) {
        const uint proxy = chunk + thread;
        float mine = 0.0;
        if (proxy < end) {
            const vec3 power = uintBitsToFloat(powers[proxy].xyz);
            const vec3 normal = proxy_normal(grid_places[proxy].w);
            mine = mean(power);
            flux += power;
            for (int channel = 0; channel < 3; ++channel) normals[channel] += power[channel] * normal;
            const vec4 here = vec4(uintBitsToFloat(grid_places[proxy].xyz), 1.0);
            middle += mine * here;
            place += here;
            if (mine > 0.0)
                lit += vec4(1.0, normal);
            else if (grid_places[proxy].w != NO_PROXY)
                dark += 1.0;
        }
        const float sum = before + running_sum_of_group(mine);
        if (proxy < end) running_sums[proxy] = sum;
        barrier();
        if (thread == PROXY_GROUP - 1) sums[0].x = sum;
        barrier();
        before = sums[0].x;
        barrier();
    }
    flux = sum_of_group(vec4(flux, 0.0)).xyz;
    for (int channel = 0; channel < 3; ++channel) normals[channel] = sum_of_group(vec4(normals[channel], 0.0)).xyz;
    middle = sum_of_group(middle);
    place = sum_of_group(place);
    lit = sum_of_group(lit) / push.per_m2;
    dark = sum_of_group(vec4(dark)).x / push.per_m2;
    if (thread != 0) return;
    const bool is_lit = middle.w > 0.0;
    voxels[voxel] = ProxyVoxel(is_lit ? middle.xyz / middle.w : place.xyz / max(place.w, 1.0), first, flux, end, normals,
                               lit.x, lit.yzw, dark);
    if (is_lit) atomicOr(lit_words[voxel / 32], 1u << voxel % 32);
}
