// GLSL twin of photons/radiance_estimate.h: reflected radiance from the photons about a point. Define
// GRID_STARTS_BINDING, GRID_PLACES_BINDING, MAP_POWERS_BINDING (of set 0), NEAREST_GROUP (threads of the group) and
// ESTIMATE (an EstimateConstants) before, and what disc_coverage.glsl wants.
//
// The k nearest are found exactly, in two sweeps through the cells or three, without a list of candidates: a histogram
// of the squared distances says in which of its buckets the k-th is; among the few in there it is selected. Where they
// are many the bucket is cut again, by the distances' bits. Then the photons up to that distance are summed.
#ifndef PHOTOND_RADIANCE_ESTIMATE_GLSL
#define PHOTOND_RADIANCE_ESTIMATE_GLSL

#include "renderer/photons/disc_coverage.glsl"
#include "renderer/photons/hash_grid.glsl"
#include "renderer/photons/kernel.glsl"
#include "renderer/photons/photon.glsl"
#include "renderer/photons/radiance_estimate_shared.h"
#include "renderer/transport/bsdf.glsl"
#include "renderer/transport/surface.glsl"

layout(constant_id = SEARCH_NEAREST_ID) const bool SEARCH_NEAREST = true;
layout(constant_id = SOFT_DISC_ID) const bool SOFT_DISC = false;
layout(constant_id = DISC_COVERAGE_ID) const bool DISC_COVERAGE = false;
layout(constant_id = DISC_MOMENTS_ID) const bool DISC_MOMENTS = false;  // whether they are asked for

layout(set = 0, binding = MAP_POWERS_BINDING, std430) readonly buffer MapPowers { uvec4 map_powers[]; };  // PhotonPower

/// Photons that are summed: all at squared distances below `bound_sq`, and the first `equals` of those at it.
struct PhotonDisc {
    float radius_m;
    float bound_sq;
    uint equals;
};

shared uint nearest_histogram[NEAREST_BUCKETS * NEAREST_GROUP];

/// This thread's counter of a bucket.
uint nearest_counter(uint bucket) { return bucket * NEAREST_GROUP + gl_LocalInvocationIndex; }
void clear_histogram() {
    for (uint bucket = 0; bucket < NEAREST_BUCKETS; ++bucket) nearest_histogram[nearest_counter(bucket)] = 0;
}
/// The bucket that holds candidate number `rank`, which counts from 1 and is made to count from that bucket's first.
uint bucket_of_rank(inout uint rank) {
    uint bucket = 0;
    for (; bucket < NEAREST_BUCKETS - 1; ++bucket) {
        const uint count = nearest_histogram[nearest_counter(bucket)];
        if (count >= rank) break;
        rank -= count;
    }
    return bucket;
}
uint bucket_of_distance(float distance_sq, float buckets_per_m2) {
    return min(uint(distance_sq * buckets_per_m2), NEAREST_BUCKETS - 1u);
}

/// KdTree::find_nearest(): the k nearest strictly within the map's radius, of which the farthest sets the disc and is
/// not in it; all of them, with the map's radius, where there are fewer.
PhotonDisc find_nearest(PhotonMapConstants map, vec3 p) {
    const HashGridConstants grid = map.grid;
    uint index;
    uvec4 point;
    float distance_sq;

    // The radius grows until k photons are within: searches that find fewer cost little.
    float radius_m = min(grid.cell_m, map.radius_m), buckets_per_m2;
    while (true) {
        clear_histogram();
        const float radius_sq = radius_m * radius_m;
        buckets_per_m2 = float(NEAREST_BUCKETS) / radius_sq;
        uint found = 0;
        GridSearch search = grid_search(grid, p, radius_m);
        while (grid_next(grid, search, radius_sq, index, point, distance_sq)) {
            if (distance_sq == radius_sq) continue;
            ++nearest_histogram[nearest_counter(bucket_of_distance(distance_sq, buckets_per_m2))];
            ++found;
        }
        if (found >= map.nearest) break;
        if (radius_m >= map.radius_m) return PhotonDisc(map.radius_m, radius_sq, 0u);
        // By what was found here, half as many more than k are expected within the next radius.
        const float wanted = sqrt(1.5 * float(map.nearest) / float(max(found, 1u)));
        radius_m = min(clamp(wanted, 1.2, 4.0) * radius_m, map.radius_m);
    }
    uint rank = map.nearest;
    const uint bucket = bucket_of_rank(rank);
    uint many = nearest_histogram[nearest_counter(bucket)];
    // The k-th is number `rank` of the `many` in that bucket whose bits are in [low, low + width).
    const float least = float(bucket) / buckets_per_m2 * 0.99999, most = float(bucket + 1u) / buckets_per_m2 * 1.00001;
    uint low = floatBitsToUint(least), width = floatBitsToUint(most) - low;
    const float reach_m = min(sqrt(most) * 1.00001, radius_m);

    while (many > NEAREST_AT_ONCE && width > 1) {
        clear_histogram();
        const uint shift = uint(max(findMSB(width) - 4, 0));
        GridSearch search = grid_search(grid, p, reach_m);
        while (grid_next(grid, search, most, index, point, distance_sq)) {
            const uint above = floatBitsToUint(distance_sq) - low;  // below `low`: wraps
            if (above < width && bucket_of_distance(distance_sq, buckets_per_m2) == bucket)
                ++nearest_histogram[nearest_counter(above >> shift)];
        }
        const uint part = bucket_of_rank(rank);
        many = nearest_histogram[nearest_counter(part)];
        low += part << shift;
        width = 1u << shift;
    }
    // The photons left in the bucket are all at one distance, or few enough to be held at once.
    float kth_sq = uintBitsToFloat(low);
    if (width > 1) {
        float nearest[NEAREST_AT_ONCE];
        for (uint i = 0; i < NEAREST_AT_ONCE; ++i) nearest[i] = INFINITY;
        GridSearch search = grid_search(grid, p, reach_m);
        while (grid_next(grid, search, most, index, point, distance_sq)) {
            const uint above = floatBitsToUint(distance_sq) - low;
            if (above >= width || bucket_of_distance(distance_sq, buckets_per_m2) != bucket) continue;
            float rest = distance_sq;
            for (uint i = 0; i < NEAREST_AT_ONCE; ++i) {
                const float nearer = min(nearest[i], rest);
                rest = max(nearest[i], rest);
                nearest[i] = nearer;
            }
        }
        for (uint i = 0; i < NEAREST_AT_ONCE; ++i)
            if (i + 1 == rank) kth_sq = nearest[i];
        uint before = 0;
        for (uint i = 0; i < NEAREST_AT_ONCE; ++i) before += nearest[i] < kth_sq ? 1u : 0u;
        rank -= before;
    }
    return PhotonDisc(sqrt(kth_sq), kth_sq, rank - 1);
}

/// A photon's flux is L |cos_p| dw dA; the estimate divides by |cos_p|, the cosine to the normal of the surface it lies on,
/// where the shading normal differs, but by no less than this.
const float LEAST_COSINE = DISC_LEAST_COSINE;
const float LEAST_NORMAL_FLOAT = 1.17549435e-38;

struct RadianceEstimate {
    vec3 radiance;        // [W m^-2 sr^-1], all photons that passed
    vec3 delta_radiance;  // the part of those whose scatterings were all delta (layer "caustic")
    uint photons;         // that passed the tests
    uint scattered;       // of them: that bring any light
    float radius_m;       // of the disc
};
/// How one lookup is made.
struct DiscQuery {
    uint turn;            // a random number, for the coverage of the disc
    uint batch_size;      // DISC_FINE_BATCH or DISC_COARSE_BATCH
    float most_radius_m;  // of a larger disc only the radius is wanted
    float radius_m;       // of the disc; 0: the map's own search says
    vec3 channels;        // with which the moments add those of light
};
RadianceEstimate no_radiance() { return RadianceEstimate(vec3(0.0), vec3(0.0), 0u, 0u, 0.0); }
DiscQuery disc_query(uint turn, uint batch_size) { return DiscQuery(turn, batch_size, INFINITY, 0.0, vec3(0.0)); }

/// DiscMoments of the last disc, where they are asked for.
struct DiscMoments {
    float w_sq, w_t;
    float sectors[DISC_SECTORS];
};
DiscMoments disc_moments;
void clear_disc_moments() {
    disc_moments.w_sq = disc_moments.w_t = 0.0;
    for (uint s = 0; s < DISC_SECTORS; ++s) disc_moments.sectors[s] = 0.0;
}
/// `light`: what a photon there brings, its channels added; `offset` from the centre, `q_sq` its square over the radius'.
void add_to_disc_moments(float light, Frame frame, vec3 offset, float q_sq) {
    const float x = dot(offset, frame.tangent), y = dot(offset, frame.bitangent);
    const uint sector = (x < 0.0 ? 1u : 0u) | (y < 0.0 ? 2u : 0u) | (abs(x) < abs(y) ? 4u : 0u);
    disc_moments.w_sq += light * light;
    disc_moments.w_t += light * (2.0 * q_sq - 1.0);
    disc_moments.sectors[sector] += light;
}

/// How far from its plane a disc of that radius counts photons.
float disc_thickness_m(float radius_m) {
    return ESTIMATE.disc_thickness_m < 0.0 ? 0.25 * radius_m : ESTIMATE.disc_thickness_m;
}

/// Reflected (and, by rough transmission, transmitted) radiance towards `wo` (local to point.shading) by the non-delta
/// lobes of `bsdf`, from that map. Photons with more than `most_scatterings` are left out.
RadianceEstimate estimate_radiance(uint map_kind, ShadingPoint point, Bsdf bsdf, vec3 wo, uint most_scatterings,
                                   DiscQuery query) {
    RadianceEstimate estimate = no_radiance();
    if (DISC_MOMENTS) clear_disc_moments();
    if (!bsdf_has_non_delta(bsdf)) return estimate;
    const vec3 normal = point.geometric_normal;
    const bool both_sides = bsdf_has_non_delta_transmission(bsdf);
    // A Lambert reflector reflects the same share of every photon, and the photon's normal says at which side it arrived.
    const bool plain = bsdf_is_lambert(bsdf) && point.shading.normal == normal;
    if (plain && wo.z <= 0.0) return estimate;

    const PhotonMapConstants map = ESTIMATE.maps[map_kind];
    if (is_empty(map.grid)) return estimate;
    const float radius_m = query.radius_m > 0.0 ? query.radius_m : map.radius_m;
    PhotonDisc disc = PhotonDisc(radius_m, radius_m * radius_m, 0u);
    if (SEARCH_NEAREST) disc = find_nearest(map, point.position);
    estimate.radius_m = disc.radius_m;
    if (disc.radius_m > query.most_radius_m) return estimate;
    // As many photons as are looked for in one place leave no disc to spread them over: no density, and of that place
    // without area no light. Nor is there one where a disc is without end.
    const float area = sqr(disc.radius_m);
    if (!(area >= LEAST_NORMAL_FLOAT && area < INFINITY)) return estimate;
    const float thickness_m = disc_thickness_m(disc.radius_m);
    const uint same_normal = octahedral_encode(11u, normal);
    const vec3 factor = plain ? bsdf_f_cos(bsdf, wo, vec3(0.0, 0.0, 1.0)) : vec3(1.0);
    const Frame disc_frame = make_frame(normal);
    const bool cut = DISC_COVERAGE && has_edges(point.position, disc.radius_m);
    DiscProbe probe;
    DiscMass mass = DiscMass(1.0, false);
    if (cut) {
        probe = probe_disc(CoverageDisc(point.position, normal, disc.radius_m, thickness_m));
        mass = disc_mass(ESTIMATE.kernel, probe, query.turn, query.batch_size);
    }

    // All photons are asked for where a place was hidden. Else some are, and all of them, from the start, once one of
    // these is hidden: a wall may stand where none of the places came to be.
    bool asks = mass.hides;
    for (bool again = true; again;) {
        again = false;
        estimate.radiance = estimate.delta_radiance = vec3(0.0);
        estimate.photons = estimate.scattered = 0;
        if (DISC_MOMENTS) clear_disc_moments();
        uint next_asked = 0;  // number of the photon
        uint equals = disc.equals;
        uint index;
        uvec4 found;
        float distance_sq;
        GridSearch search = grid_search(map.grid, point.position, disc.radius_m);
        while (grid_next(map.grid, search, disc.bound_sq, index, found, distance_sq)) {
            if (distance_sq == disc.bound_sq) {
                if (equals == 0) continue;
                --equals;
            }
            const vec3 position = uintBitsToFloat(found.xyz);
            const float height_m = abs(dot(normal, position - point.position));
            if (height_m > thickness_m || photon_scatterings(found.w) > most_scatterings) continue;
            float side = 1.0;
            if ((found.w & PHOTON_NORMAL_BITS) != same_normal) {
                side = dot(photon_normal(found.w), normal);
                if (side < 0.0 && !both_sides) continue;
                if (!SOFT_DISC && abs(side) < DISC_COSINE) continue;
            }
            if (cut && (asks || estimate.photons == next_asked)) {
                next_asked = 2 * estimate.photons + 1;
                if (!disc_sees(probe, position)) {
                    if (asks) continue;
                    asks = again = true;
                    break;
                }
            }
            float weight = kernel_evaluate(ESTIMATE.kernel, distance_sq / area);
            if (SOFT_DISC) weight *= abs(side) * (thickness_m > 0.0 ? 1.0 - height_m / thickness_m : 1.0);
            const uvec4 power = map_powers[map.grid.first_point + index];
            vec3 brought = uintBitsToFloat(power.xyz);
            if (!plain) {
                const vec3 direction = photon_direction(power.w);
                const vec3 wi = to_local(point.shading, direction);
                const bool same = (found.w & PHOTON_NORMAL_BITS) == same_normal;
                const float cos_p = dot(direction, same ? normal : photon_normal(found.w));
                // A photon of a curved surface's next facet may have come from below this one's horizon.
                const bool same_side = (dot(direction, normal) > 0.0) == (side > 0.0);
                const float share = same_side ? 1.0 / max(abs(cos_p), LEAST_COSINE) : 0.0;
                brought *= share * bsdf_f_cos(bsdf, wo, wi);
            }
            const vec3 reflected = weight * brought;
            estimate.radiance += reflected;
            if (photon_all_delta(found.w)) estimate.delta_radiance += reflected;
            ++estimate.photons;
            if (plain || !is_black(brought)) {
                ++estimate.scattered;
                if (DISC_MOMENTS)
                    add_to_disc_moments(dot(query.channels * factor, brought), disc_frame, position - point.position,
                                        distance_sq / area);
            }
        }
    }
    estimate.radiance *= mass.inverse / area * factor;
    estimate.delta_radiance *= mass.inverse / area * factor;
    return estimate;
}

struct IrradianceEstimate {
    vec3 irradiance;  // [W m^-2]
    float radius_m;   // of the disc
};

/// Of a Lambert reflector there; `normal` is the one that shades.
IrradianceEstimate estimate_irradiance(uint map_kind, vec3 position, vec3 geometric_normal, vec3 normal,
                                       uint most_scatterings, DiscQuery query) {
    ShadingPoint point;
    point.position = position;
    point.geometric_normal = geometric_normal;
    point.smooth_normal = normal;
    point.shading = make_frame(normal);
    const Bsdf white = bsdf_lambert(to_local(point.shading, geometric_normal), vec3(1.0));
    const RadianceEstimate estimate =
        estimate_radiance(map_kind, point, white, vec3(0.0, 0.0, 1.0), most_scatterings, query);
    return IrradianceEstimate(PI * estimate.radiance, estimate.radius_m);
}

#endif
