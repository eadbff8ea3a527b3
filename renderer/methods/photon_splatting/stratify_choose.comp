#version 460
// The splats of cells: CPU twin Chooser of stratification.cpp, whose double numbers are pairs of floats here. A thread a cell,
// that of its first photon: most cells hold few.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PHOTONS_BINDING 0
#define ORDER_BINDING 1
#define KEYS_BINDING 2
#define PLACES_BINDING 3
#include "renderer/core/rng.glsl"
#include "renderer/methods/photon_splatting/stratification.glsl"

layout(local_size_x = STRATIFICATION_GROUP) in;
#include "renderer/backends/gpu/invocation.glsl"
layout(set = 0, binding = 4, scalar) readonly buffer State { uint state[STRATIFICATION_STATE_WORDS]; };
layout(set = 0, binding = 5, scalar) readonly buffer Joined { uint joined[]; };
layout(set = 0, binding = 6, scalar) readonly buffer Offsets { uint offsets[]; };  // of the cells' splats
layout(set = 0, binding = 7, scalar) writeonly buffer Sources { SplatSourceRecord sources[]; };

/// A number of about 48 bits: the sum of the two. [Knuth 1969] TAOCP 2, 4.2.2, theorem B.
struct Pair {
    float high;
    float low;
};
Pair plus(Pair a, float b) {
    precise const float sum = a.high + b;
    precise const float part = sum - a.high;
    precise const float error = (a.high - (sum - part)) + (b - part);
    precise const float low = a.low + error;
    precise const float high = sum + low;
    precise const float rest = low - (high - sum);
    return Pair(high, rest);
}
Pair plus(Pair a, Pair b) { return plus(plus(a, b.high), b.low); }
Pair times(Pair a, float b) {
    precise const float product = a.high * b;
    precise const float error = fma(a.high, b, -product);
    return plus(Pair(product, 0.0), fma(a.low, b, error));
}
Pair divided(Pair a, float b) {
    precise const float quotient = a.high / b;
    precise const float rest = fma(-quotient, b, a.high) + a.low;
    return plus(Pair(quotient, 0.0), rest / b);
}
bool less_or_equal(Pair a, Pair b) { return a.high < b.high || (a.high == b.high && a.low <= b.low); }

struct Cell {
    uint begin;
    uint end;
    uint level;
    uint64_t code;  // of its first photon
    float scale;    // power of two that makes its powers be about 1 or less: no sum overflows
};

vec3 scaled_power(Cell cell, uint k) { return sorted_photon(k).power_w * cell.scale; }
/// Adds a photon's share of the cell's power, the sum of RGB.
Pair plus_share(Pair sum, vec3 power) { return plus(plus(plus(sum, power.x), power.y), power.z); }
float weight(vec3 power) { return power.x + power.y + power.z; }

float scale_of(uint begin, uint end) {
    float greatest = 0.0;
    for (uint k = begin; k < end; ++k) greatest = max(greatest, max_component(sorted_photon(k).power_w));
    const uint exponent = clamp(floatBitsToUint(greatest) >> 23, 1u, 253u);
    return uintBitsToFloat((254u - exponent) << 23);
}
vec3 unscaled(Cell cell, vec3 scaled) {
    return scaled * uintBitsToFloat((254u << 23) - floatBitsToUint(cell.scale));  // over a power of two
}

/// Sums, scaled.
vec3 power_sum(Cell cell) {
    Pair sum[3] = {Pair(0.0, 0.0), Pair(0.0, 0.0), Pair(0.0, 0.0)};
    for (uint k = cell.begin; k < cell.end; ++k) {
        const vec3 power = scaled_power(cell, k);
        for (int c = 0; c < 3; ++c) sum[c] = plus(sum[c], power[c]);
    }
    return vec3(sum[0].high, sum[1].high, sum[2].high);
}
vec3 mean_power_w(Cell cell) { return unscaled(cell, power_sum(cell) / float(cell.end - cell.begin)); }

/// 53 bits of a number in [0, 1).
uint64_t random_offset(Cell cell) {
    RandomStream random = make_random_stream(push.seed, RANDOM_DOMAIN_STRATIFICATION, push.pass,
                                             cell.code >> 3 * cell.level << 4 | uint64_t(cell.level));
    const uint64_t high = uint64_t(random_stream_next_bits(random));
    return high << 21 | uint64_t(random_stream_next_bits(random) >> 11);
}

/// Equidistant photons: the number of those before the i-th is the whole part of (offset + i) count / splats.
void sample_evenly(Cell cell, uint out_at) {
    const uint64_t count = uint64_t(cell.end - cell.begin), offset = random_offset(cell);
    const uint64_t before_first = ((offset >> 21) * count + ((offset & 0x1ffffful) * count >> 21)) >> 32;
    const float share = float(count) / float(push.splats_per_cell);
    const vec3 mean_w = push.mean_power != 0 ? mean_power_w(cell) : vec3(0.0);
    for (uint i = 0; i < push.splats_per_cell; ++i) {
        const uint k = cell.begin + uint((uint64_t(i) * count + before_first) / uint64_t(push.splats_per_cell));
        const vec3 power_w = push.mean_power != 0 ? mean_w : sorted_photon(k).power_w * share;
        sources[out_at + i] = SplatSourceRecord(places[k], power_w, share);
    }
}

/// Equidistant points on the cumulative power.
void sample_by_power(Cell cell, uint out_at) {
    Pair total = Pair(0.0, 0.0);
    for (uint k = cell.begin; k < cell.end; ++k) total = plus_share(total, scaled_power(cell, k));
    const uint64_t offset = random_offset(cell);
    const float splats = float(push.splats_per_cell);
    const vec3 mean_w = push.mean_power != 0 ? mean_power_w(cell) : vec3(0.0);
    const Pair spacing = divided(total, splats);
    // Of the offset, whole numbers of 24 bits and what is left of 53.
    const Pair first = plus(times(spacing, float(uint(offset >> 29)) * 5.9604644775390625e-8),
                            times(spacing, float(uint(offset & 0x1ffffffful)) * 1.1102230246251565e-16));
    uint k = cell.begin, chosen = k;  // the last one up to k that has a share
    vec3 power = scaled_power(cell, k);
    Pair reached = plus_share(Pair(0.0, 0.0), power);  // cumulative share of the photons up to k
    for (uint i = 0; i < push.splats_per_cell; ++i) {
        const Pair point = plus(times(spacing, float(i)), first);
        while (less_or_equal(reached, point) && k + 1 < cell.end) {
            const vec3 next = scaled_power(cell, ++k);
            if (is_black(next)) continue;
            reached = plus_share(reached, next);
            power = next;
            chosen = k;
        }
        // Over its share first: both may be small.
        const vec3 splat_w = unscaled(cell, power / weight(power) * (total.high / splats));
        sources[out_at + i] = SplatSourceRecord(places[chosen], push.mean_power != 0 ? mean_w : splat_w,
                                                float(cell.end - cell.begin) / splats);
    }
}

uint closest_to_mean(Cell cell) {
    Pair sum[3] = {Pair(0.0, 0.0), Pair(0.0, 0.0), Pair(0.0, 0.0)};
    for (uint k = cell.begin; k < cell.end; ++k) {
        const vec3 p = sorted_photon(k).position;
        for (int c = 0; c < 3; ++c) sum[c] = plus(sum[c], p[c]);
    }
    Pair mean[3];
    for (int c = 0; c < 3; ++c) mean[c] = divided(sum[c], float(cell.end - cell.begin));
    uint best = cell.begin;
    float least_m2 = INFINITY;
    for (uint k = cell.begin; k < cell.end; ++k) {
        const vec3 p = sorted_photon(k).position;
        vec3 d;  // of two photons the same, and the first is taken
        for (int c = 0; c < 3; ++c) d[c] = plus(plus(Pair(p[c], 0.0), -mean[c].high), -mean[c].low).high;
        if (dot(d, d) < least_m2) best = k, least_m2 = dot(d, d);
    }
    return best;
}

uint dominant_direction(Cell cell) {
    Pair sum[3] = {Pair(0.0, 0.0), Pair(0.0, 0.0), Pair(0.0, 0.0)};
    for (uint k = cell.begin; k < cell.end; ++k) {
        const vec3 along = weight(scaled_power(cell, k)) * sorted_photon(k).direction;
        for (int c = 0; c < 3; ++c) sum[c] = plus(sum[c], along[c]);
    }
    const vec3 mean = vec3(sum[0].high, sum[1].high, sum[2].high);
    uint best = cell.begin;
    float greatest = -INFINITY;
    for (uint k = cell.begin; k < cell.end; ++k) {
        const float along = dot(sorted_photon(k).direction, mean);
        if (along > greatest) best = k, greatest = along;
    }
    return best;
}

/// One photon with the power of all.
void take_representative(Cell cell, uint out_at) {
    const bool to_mean = push.representative == REPRESENTATIVE_CLOSEST_TO_MEAN;
    const uint k = to_mean ? closest_to_mean(cell) : dominant_direction(cell);
    const vec3 power_w = push.mean_power != 0 ? mean_power_w(cell) : unscaled(cell, power_sum(cell));
    sources[out_at] = SplatSourceRecord(places[k], power_w, float(cell.end - cell.begin));
}

void choose(Cell cell, uint out_at) {
    const uint count = cell.end - cell.begin;
    const bool takes_one = push.representative >= REPRESENTATIVE_CLOSEST_TO_MEAN;
    if (takes_one ? count == 1 : count <= push.splats_per_cell) {
        for (uint i = 0; i < count; ++i)
            sources[out_at + i] = SplatSourceRecord(places[cell.begin + i], sorted_photon(cell.begin + i).power_w, 1.0);
        return;
    }
    cell.scale = scale_of(cell.begin, cell.end);
    if (takes_one)
        take_representative(cell, out_at);
    else if (push.representative == REPRESENTATIVE_BY_POWER)
        sample_by_power(cell, out_at);
    else
        sample_evenly(cell, out_at);
}

void main() {
    const uint k = flat_index();
    if (k >= push.photons) return;
    const uint after = k + 1 < push.photons ? offsets[k + 1] : state[STRATIFICATION_SOURCES];
    if (after == offsets[k]) return;
    Cell cell = Cell(k, k + 1, 0, sorted_code(k), 1.0);
    if (cell.code < outside()) {
        if (push.minimum_photons > 1) cell.level = joined[k];
        cell.end = block_end(k, cell.code, cell.level);
    }
    choose(cell, offsets[k]);
}
