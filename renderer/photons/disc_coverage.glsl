// GLSL twin of photons/disc_coverage.h: how much of a disc of density estimation lies on surface that light can reach.
// Define COVERAGE (a DiscCoverageConstants) and EDGE_WORD(index), the tables' words, before (edge_tree.glsl).
#ifndef PHOTOND_DISC_COVERAGE_GLSL
#define PHOTOND_DISC_COVERAGE_GLSL

#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/photons/disc_coverage_shared.h"
#include "renderer/photons/edge_tree.glsl"
#include "renderer/photons/kernel.glsl"

/// A random number made from two.
uint disc_turn(vec2 u) { return hash32(floatBitsToUint(u.x) ^ hash32(floatBitsToUint(u.y))); }

/// One more number in [0, 1) of a lookup with that turn.
float disc_lot(uint turn) { return to_unit_float(hash32(turn ^ 0x51ed270bu)); }

struct CoverageDisc {
    vec3 centre, normal;
    float radius_m, thickness_m;
};

/// Area of the surface that was hit over that of its projection to the disc: one over the cosine. 0 where there is none
/// that makes at most 60 degrees with the disc.
float area_over_disc(Hit hit, vec3 normal) {
    if (!hit_valid(hit)) return 0.0;
    const TriangleCorners t = world_triangle(hit.instance, hit.triangle);
    const vec3 across = cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
    const float cosine = abs(dot(across, normal)) / length(across);
    return cosine >= DISC_COSINE ? 1.0 / cosine : 0.0;
}

/// From above a disc to just above a point of a surface.
Ray ray_between(vec3 eye, vec3 point, vec3 normal, float radius_m) {
    const vec3 to = point + DISC_ABOVE_POINT * radius_m * normal - eye;
    const float length_m = length(to);
    return Ray(eye, length_m > 0.0 ? to / length_m : normal, length_m);
}

struct PlaceProbe {
    vec3 place, normal;
    float radius_m;
    float most_lift_m;  // negative until it is known
};
PlaceProbe probe_place(vec3 place, vec3 normal, float radius_m) { return PlaceProbe(place, normal, radius_m, -1.0); }

/// PlaceProbe::sees().
bool place_sees(inout PlaceProbe probe, vec3 photon) {
    const float distance_m = length(photon - probe.place);
    if (!has_edges(probe.place, distance_m)) return true;
    if (probe.most_lift_m < 0.0) {
        const Hit above =
            closest_hit(Ray(offset_ray_origin(probe.place, probe.normal), probe.normal, 2.0 * probe.radius_m));
        probe.most_lift_m = hit_valid(above) ? 0.5 * above.t : probe.radius_m;
    }
    const vec3 eye = probe.place + min(probe.most_lift_m, distance_m) * probe.normal;
    return !occluded(ray_between(eye, photon, probe.normal, distance_m));
}

struct DiscProbe {
    CoverageDisc disc;
    float lift_m;
    vec3 eye;  // that far above the centre
};
DiscProbe probe_disc(CoverageDisc disc) {
    const float wanted = max(disc.thickness_m, DISC_LEAST_LIFT * disc.radius_m);
    const Hit above = closest_hit(Ray(offset_ray_origin(disc.centre, disc.normal), disc.normal, wanted));
    const float lift_m = hit_valid(above) ? 0.5 * above.t : wanted;
    return DiscProbe(disc, lift_m, disc.centre + lift_m * disc.normal);
}

/// DiscProbe::sees().
bool disc_sees(DiscProbe probe, vec3 photon) {
    return !occluded(ray_between(probe.eye, photon, probe.disc.normal, probe.disc.radius_m));
}

/// Looks the place up at that offset from the disc's centre: the area of the surface there over the place's own, 0
/// where there is none, and whether it is seen from the eye.
float look_place_up(DiscProbe probe, vec3 offset, float u_sq_m2, out bool covered) {
    const CoverageDisc disc = probe.disc;
    const vec3 eye = probe.eye;
    const float lift_m = probe.lift_m;
    const float length_m = sqrt(u_sq_m2 + sqr(lift_m));
    const Hit slanted =
        closest_hit(Ray(eye, (offset - lift_m * disc.normal) / length_m, (1.0 + DISC_SAME_PLANE) * length_m));
    float area = 0.0;
    if (abs(lift_m * (1.0 - slanted.t / length_m)) <= min(DISC_SAME_PLANE * disc.radius_m, 0.5 * lift_m))
        area = area_over_disc(slanted, disc.normal);
    covered = area > 0.0;
    if (covered) return area;
    const Hit below = closest_hit(Ray(eye + offset, -disc.normal, lift_m + disc.thickness_m));
    const float height_m = lift_m - below.t;
    if (abs(height_m) <= disc.thickness_m && u_sq_m2 + sqr(height_m) <= sqr(disc.radius_m))
        area = area_over_disc(below, disc.normal);
    if (area > 0.0)
        covered =
            !occluded(ray_between(eye, disc.centre + offset + height_m * disc.normal, disc.normal, disc.radius_m));
    return area;
}

struct DiscMass {
    float inverse;
    bool hides;
};
/// DiscProbe::mass(), by batches of so many places.
DiscMass disc_mass(KernelRecord kernel, DiscProbe probe, uint turn, uint batch_size) {
    DiscMass mass = DiscMass(1.0, false);
    const Frame frame = make_frame(probe.disc.normal);
    uint looked_up = 0, covered = 0;
    float area = 0.0, product = 1.0;
    while (looked_up < DISC_MOST_PLACES && abs(product) > DISC_NOTHING_LOST &&
           (looked_up < 2 * batch_size || covered < batch_size)) {
        const uint seed = turn + 3 * (looked_up / batch_size);
        const vec3 start =
            vec3(to_unit_float(hash32(seed)), to_unit_float(hash32(seed + 1)), to_unit_float(hash32(seed + 2)));
        float of_batch = 0.0;
        for (uint i = 0; i < batch_size; ++i) {
            const vec3 place = fract(start + float(i) * vec3(DISC_STEP_X, DISC_STEP_Y, DISC_STEP_Z));
            const float u_m = kernel_sample_disc(kernel, place.x) * sqrt(place.z) * probe.disc.radius_m;
            const float angle = 2.0 * PI * place.y;
            const vec3 offset = u_m * (cos(angle) * frame.tangent + sin(angle) * frame.bitangent);
            bool seen;
            const float of_place = look_place_up(probe, offset, sqr(u_m), seen);
            mass.hides = mass.hides || (of_place > 0.0 && !seen);
            if (!seen) continue;
            of_batch += of_place;
            ++covered;
        }
        looked_up += batch_size;
        area += of_batch;
        product *= 1.0 - of_batch / float(batch_size);
        mass.inverse += product;
    }
    mass.inverse += product * (float(looked_up) - area) / max(area, 1.0);
    mass.inverse = min(mass.inverse, 1.0 / DISC_LEAST_MASS);
    return mass;
}

#endif
