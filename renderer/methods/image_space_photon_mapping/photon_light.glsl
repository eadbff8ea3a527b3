// What light a photon brings to a pixel's point, through a quad or a volume (methods.md). Define FOOTPRINTS (the
// PhotonScatterConstants) and FOOTPRINT_RADIUS_M (of the map's) before.
#ifndef PHOTOND_PHOTON_LIGHT_GLSL
#define PHOTOND_PHOTON_LIGHT_GLSL

#include "renderer/gbuffer/receiver.glsl"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/methods/image_space_photon_mapping/photon_scatter_shared.h"
#include "renderer/photons/disc_coverage_shared.h"
#include "renderer/photons/kernel.glsl"
#include "renderer/photons/photon.glsl"

layout(constant_id = FOOTPRINT_ID) const uint FOOTPRINT = FOOTPRINT_QUAD;

/// A photon whose footprint reaches a point.
struct FootprintHit {
    float share_per_m2;  // of its power that counts there, before the point's BSDF
    float side;          // between the normals
    vec3 normal;
};

/// By a quad, or by a volume.
float footprint_of(float distance_sq, float height_sq, bool quad) {
    const float radius_sq = sqr(FOOTPRINT_RADIUS_M);
    if (quad)
        return height_sq <= sqr(QUAD_HEIGHT) * radius_sq
                   ? kernel_evaluate(FOOTPRINTS.kernel, distance_sq / radius_sq) / radius_sq
                   : 0.0;
    const float q_sq = (distance_sq + (1.0 / sqr(FOOTPRINTS.volume_height) - 1.0) * height_sq) / radius_sq;
    return q_sq < 1.0 ? kernel_evaluate(FOOTPRINTS.kernel, q_sq) / radius_sq : 0.0;
}

/// False: it does not reach it, or lies on the other side of a surface that shows no light from there. `cut`: the point
/// divides by what light can reach of a quad.
bool reaches_point(uvec4 place, GBufferPoint point, Receiver receiver, bool cut, out FootprintHit hit) {
    const vec3 offset = point.position - uintBitsToFloat(place.xyz);
    const float distance_sq = dot(offset, offset);
    if (!(distance_sq < sqr(FOOTPRINT_RADIUS_M))) return false;
    if (photon_scatterings(place.w) > (point.kind & GBUFFER_SCATTERINGS)) return false;
    hit.normal = photon_normal(place.w);
    // The weight of agreement: both normals are of facets, so that it tends to 1 as footprints shrink.
    hit.side = dot(hit.normal, point.geometric_normal);
    const bool both_sides = is_general(point) ? bsdf_has_non_delta_transmission(receiver.rough)
                                              : point.normal == vec3(0.0);
    if (hit.side <= 0.0 && !both_sides) return false;
    const float height_sq = sqr(dot(hit.normal, offset));
    hit.share_per_m2 = 0.0;
    if (FOOTPRINT != FOOTPRINT_VOLUME) hit.share_per_m2 = footprint_of(distance_sq, height_sq, true);
    if (FOOTPRINT == FOOTPRINT_VOLUME || (FOOTPRINT == FOOTPRINT_AUTO && !cut))
        hit.share_per_m2 = max(hit.share_per_m2, footprint_of(distance_sq, height_sq, false));
    return hit.share_per_m2 > 0.0;
}

/// What light a photon brings to a point, of its power: of Lambert points irradiance, of others radiance. `wi`: towards
/// where it came from; `cos_p`: between that and the normal of the surface it lies on; `side`: between the normals.
vec3 light_of(GBufferPoint point, Receiver receiver, vec3 wi, float cos_p, float side) {
    // A photon of a curved surface's next facet may have come from below this one's horizon.
    if ((dot(wi, point.geometric_normal) > 0.0) != (side > 0.0)) return vec3(0.0);
    const float share = 1.0 / max(abs(cos_p), DISC_LEAST_COSINE);
    if (is_general(point))
        return share * bsdf_f_cos(receiver.rough, receiver.wo, to_local(receiver.surface.shading, wi));
    if (point.normal == vec3(0.0)) return vec3(1.0);
    return vec3(point.normal == point.geometric_normal ? 1.0 : share * max(dot(point.normal, wi), 0.0));
}

vec3 photon_light(uvec4 power, GBufferPoint point, Receiver receiver, FootprintHit hit) {
    const vec3 wi = photon_direction(power.w);
    return hit.share_per_m2 * abs(hit.side) * uintBitsToFloat(power.xyz) *
           light_of(point, receiver, wi, dot(wi, hit.normal), hit.side);
}

#endif
