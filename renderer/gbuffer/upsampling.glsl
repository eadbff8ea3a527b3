// Light at fewer pixels than there are, and how a pixel without light of its own takes it from those about it: of each
// block of n x n pixels one is lit, and a pixel between four of those has their mean by bilinear weights, times weights
// of agreement [Yao 2011, section 3.5]. Define SUB_POINTS (an array of GBufferPoint) before, and SUB_SUMS (what they are lit by)
// where pixels take it.
#ifndef PHOTOND_UPSAMPLING_GLSL
#define PHOTOND_UPSAMPLING_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/gbuffer/split_buffer.glsl"
#include "renderer/gbuffer/upsampling_shared.h"

layout(constant_id = UPSAMPLING_ID) const uint UPSAMPLING = UPSAMPLING_GEOMETRY;

/// The four about a pixel.
struct SubSamples {
    uint points[4];
    float weights[4];
    float total;
};

/// Which of a block's pixels is lit, along either axis.
uint sub_sample_offset(SplitRecord split) { return split.side / 2u; }
bool is_sub_sample(SplitRecord split, uint x, uint y) {
    const uint offset = sub_sample_offset(split);
    return x % split.side == offset && y % split.side == offset;
}

/// How much a lit pixel's light is worth for another. `height_m`: how far off the pixel's plane it may be, or little more.
float agreement(GBufferPoint lit, GBufferPoint point, float height_m) {
    if (!is_lit(lit) || is_general(lit)) return 0.0;
    float weight = 1.0;
    if (UPSAMPLING >= UPSAMPLING_NORMAL) weight *= max(dot(lit.geometric_normal, point.geometric_normal), 0.0);
    if (UPSAMPLING >= UPSAMPLING_GEOMETRY) {
        const float lit_height_m = dot(point.geometric_normal, lit.position - point.position);
        weight *= exp(-sqr(lit_height_m / height_m));
    }
    return weight;
}

SubSamples sub_samples_of(SplitRecord split, uint x, uint y, GBufferPoint point, float height_m) {
    SubSamples found;
    found.total = 0.0;
    const int side = int(split.side), offset = int(sub_sample_offset(split));
    const ivec2 size = ivec2(split.width, split.height);
    const ivec2 count = (size - offset + side - 1) / side;
    const vec2 place = (vec2(x, y) - float(offset)) / float(side);
    const vec2 low = floor(place), part = place - low;
    for (int i = 0; i < 4; ++i) {
        const ivec2 corner = ivec2(i % 2, i / 2);
        const ivec2 at = clamp(ivec2(low) + corner, ivec2(0), max(count - 1, ivec2(0)));
        const vec2 share = mix(1.0 - part, part, vec2(corner));
        float weight = UPSAMPLING == UPSAMPLING_NEAREST ? ((share.x > 0.5 || (share.x == 0.5 && corner.x == 0)) &&
                                                           (share.y > 0.5 || (share.y == 0.5 && corner.y == 0)) ? 1.0 : 0.0)
                                                        : share.x * share.y;
        const bool exists = all(greaterThan(count, ivec2(0)));
        const ivec2 pixel = exists ? at * side + offset : ivec2(0);
        found.points[i] = split_point_of(split, uint(pixel.x), uint(pixel.y));
        weight = exists && weight > 0.0 ? weight * agreement(SUB_POINTS[found.points[i]], point, height_m) : 0.0;
        found.weights[i] = weight;
        found.total += weight;
    }
    return found;
}

#ifdef SUB_SUMS
vec3 light_of_sub_samples(SubSamples from) {
    vec3 light = vec3(0.0);
    for (int i = 0; i < 4; ++i)
        if (from.weights[i] > 0.0) light += from.weights[i] * SUB_SUMS[from.points[i]];
    return light / from.total;
}
#endif

/// Whether a pixel is lit itself: what is not Lambert depends on where it is seen from, and where no lit pixel agrees
/// there is nothing to take light from.
bool lights_itself(SplitRecord split, uint x, uint y, GBufferPoint point, float height_m) {
    if (!is_lit(point)) return false;
    if (split.side == 1u || is_sub_sample(split, x, y) || is_general(point)) return true;
    return sub_samples_of(split, x, y, point, height_m).total < UPSAMPLING_LEAST;
}

#endif
