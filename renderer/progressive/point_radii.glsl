// GLSL twin of progressive/point_records.h: what is known of a pixel's discs, and what a pass adds to it. Define
// POINTS_BEFORE_BINDING and POINTS_AFTER_BINDING (of set 0), the records as the last pass and this one leave them, and
// PROGRESSIVE (a ProgressiveConstants) before.
#ifndef PHOTOND_POINT_RADII_GLSL
#define PHOTOND_POINT_RADII_GLSL

#include "renderer/photons/radiance_estimate.glsl"
#include "renderer/progressive/progressive_shared.h"

layout(constant_id = RADIUS_RULE_ID) const uint RADIUS_RULE = RADIUS_RULE_GLOBAL;

layout(set = 0, binding = POINTS_BEFORE_BINDING, scalar) readonly buffer PointsBefore { float points_before[]; };
layout(set = 0, binding = POINTS_AFTER_BINDING, scalar) writeonly buffer PointsAfter { float points_after[]; };

// Words of a record: radius, photons; of both tests w_sq and next_test; w_t, or the sectors.
const uint POINT_WORDS = RADIUS_RULE == RADIUS_RULE_LOCAL ? 2u : RADIUS_RULE == RADIUS_RULE_RADIAL ? 5u : 4u + DISC_SECTORS;
const bool POINTS_HAVE_RADII = RADIUS_RULE >= RADIUS_RULE_LOCAL;

/// What this pass gathers for the thread's pixel, by map; radius 0: not asked for.
struct PassPoint {
    float radius_m;
    float photons;
    DiscMoments moments;
};
PassPoint pass_points[2];

void clear_pass_points() {
    clear_disc_moments();
    for (uint kind = 0; kind < 2; ++kind) pass_points[kind] = PassPoint(0.0, 0.0, disc_moments);
}

/// Adds what the last disc held.
void gather_point(uint kind, uint scattered) {
    pass_points[kind].photons += float(scattered);
    if (!DISC_MOMENTS) return;
    pass_points[kind].moments.w_sq += disc_moments.w_sq;
    pass_points[kind].moments.w_t += disc_moments.w_t;
    for (uint s = 0; s < DISC_SECTORS; ++s) pass_points[kind].moments.sectors[s] += disc_moments.sectors[s];
}

/// PointRadii::radius_m() of a point in that place.
float point_radius_m(uint kind, uint pixel, vec3 position) {
    const float known_m = points_before[PROGRESSIVE.radii[kind].first_word + pixel * POINT_WORDS];
    if (known_m > 0.0) return known_m;
    if (pass_points[kind].radius_m > 0.0) return pass_points[kind].radius_m;
    float first_m = PROGRESSIVE.first_radius_m;
    if (first_m == 0.0)
        first_m = clamp(find_nearest(PROGRESSIVE.radii[kind].pilot, position).radius_m, PROGRESSIVE.least_radius_m,
                        PROGRESSIVE.most_radius_m);
    pass_points[kind].radius_m = first_m;
    return first_m;
}

/// Of a record whose photons are enough for a test.
bool is_curved(float w_sq, float w_t, float sectors[DISC_SECTORS]) {
    if (RADIUS_RULE == RADIUS_RULE_RADIAL) return 3.0 * sqr(w_t) > sqr(POINT_RADIAL_CURVED) * w_sq;
    float mean = 0.0, squares = 0.0;
    for (uint s = 0; s < DISC_SECTORS; ++s) mean += sectors[s] / float(DISC_SECTORS);
    for (uint s = 0; s < DISC_SECTORS; ++s) squares += sqr(sectors[s] - mean);
    return float(DISC_SECTORS) * squares > POINT_SECTOR_CURVED * w_sq;
}

/// PointRadii::end_pass() of the thread's pixel, in one map.
void store_point(uint kind, uint pixel) {
    const PassPoint pass = pass_points[kind];
    const uint at = PROGRESSIVE.radii[kind].first_word + pixel * POINT_WORDS;
    float radius_m = points_before[at], photons = points_before[at + 1];
    if (radius_m == 0.0) radius_m = pass.radius_m;
    if (RADIUS_RULE == RADIUS_RULE_LOCAL) {
        if (pass.photons > 0.0) {
            const float kept = photons + PROGRESSIVE.alpha * pass.photons;
            radius_m *= sqrt(kept / (photons + pass.photons));
            photons = kept;
        }
        points_after[at] = radius_m;
        points_after[at + 1] = photons;
        return;
    }
    float w_sq = points_before[at + 2], next_test = points_before[at + 3], w_t = 0.0;
    float sectors[DISC_SECTORS];
    if (RADIUS_RULE == RADIUS_RULE_RADIAL) w_t = points_before[at + 4] + pass.moments.w_t;
    for (uint s = 0; s < DISC_SECTORS; ++s)
        sectors[s] = (RADIUS_RULE == RADIUS_RULE_SECTOR ? points_before[at + 4 + s] : 0.0) + pass.moments.sectors[s];
    photons += pass.photons;
    w_sq += pass.moments.w_sq;
    if (pass.photons > 0.0 && photons >= next_test) {
        while (photons >= next_test) next_test *= 2.0;
        if (is_curved(w_sq, w_t, sectors)) {
            radius_m *= POINT_HALVED;
            photons = w_sq = w_t = 0.0;
            next_test = POINT_FIRST_TEST;
            for (uint s = 0; s < DISC_SECTORS; ++s) sectors[s] = 0.0;
        }
    }
    points_after[at] = radius_m;
    points_after[at + 1] = photons;
    points_after[at + 2] = w_sq;
    points_after[at + 3] = next_test;
    if (RADIUS_RULE == RADIUS_RULE_RADIAL) points_after[at + 4] = w_t;
    if (RADIUS_RULE == RADIUS_RULE_SECTOR)
        for (uint s = 0; s < DISC_SECTORS; ++s) points_after[at + 4 + s] = sectors[s];
}

#endif
