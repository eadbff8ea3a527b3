#version 460
// The splats of a batch of photons, a thread a splat: CPU twin SplatMaker::add() and place_beams() (splat_batch.cpp).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/methods/photon_splatting/splat_shared.h"
#include "renderer/methods/photon_splatting/stratification_shared.h"
#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/backends/gpu/counters.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/photons/kernel.glsl"
#include "renderer/photons/photon.glsl"
#include "renderer/photons/reflected_photon_shared.h"
#include "renderer/transport/sampling.glsl"

layout(constant_id = SPLAT_HAS_BEAMS_ID) const bool SPLAT_HAS_BEAMS = true;
layout(constant_id = SPLAT_NORMALISED_ID) const bool SPLAT_NORMALISED = false;
layout(constant_id = SPLAT_STRATIFIED_ID) const bool SPLAT_STRATIFIED = false;

layout(local_size_x = SPLAT_GROUP) in;
layout(push_constant, scalar) uniform Push { SplatMakePush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { SplatConstants constants; };
layout(set = 0, binding = 2, scalar) readonly buffer State { uint state[REFLECTION_STATE_WORDS]; };
layout(set = 0, binding = 3, scalar) readonly buffer Photons { ReflectedPhotonRecord photons[]; };
layout(set = 0, binding = 4, scalar) readonly buffer Order { uint order[]; };
layout(set = 0, binding = 5, scalar) readonly buffer Surfaces { ReflectingSurfaceRecord surfaces[]; };
layout(set = 0, binding = 6, scalar) writeonly buffer Splats { Splat splats[]; };
layout(set = 0, binding = 7, scalar) readonly buffer Sources { SplatSourceRecord sources[]; };  // SPLAT_STRATIFIED
layout(set = 0, binding = 8, scalar) readonly buffer BeamCells { BeamCell beam_cells[]; };
layout(set = 0, binding = 9, scalar) readonly buffer BeamCasters { float beam_casters_m[]; };

const uint64_t STREAM_STEP = 0x9e3779b97f4a7c15ul;  // of RandomStream: from a number to the next

/// The i-th of several directions of a photon: points of a lattice, shifted for the photon, so that they are spread evenly
/// over the hemisphere. [Roberts 2018] The Unreasonable Effectiveness of Quasirandom Sequences.
vec3 splat_direction(vec3 normal, vec2 offset, uint i) {
    const vec2 u = fract(offset + float(i + 1) * vec2(0.75487766625, 0.56984029100));
    return to_world(make_frame(normal), sample_cosine_hemisphere(min(u, vec2(BELOW_ONE))));
}

/// Twin of BeamSizes::radius_m().
float beam_radius_m(vec3 landing, float distance_m, uint caster, float photons) {
    float radius_m = constants.beam_radius_m;
    if (constants.beam_levels > 0) {
        uint node = 1;
        for (uint level = 0; level < constants.beam_levels; ++level)
            node = 2 * node + (landing[beam_cells[node].axis] < beam_cells[node].split_or_radius ? 0 : 1);
        radius_m = beam_cells[node].split_or_radius;
    }
    radius_m *= sqrt(photons);
    if (constants.beam_casters == 0) return radius_m;
    if (caster < constants.beam_casters) radius_m = min(radius_m, beam_casters_m[caster]);
    return min(radius_m, max(BEAM_WAY_SHARE * distance_m, BEAM_LEAST_SHARE * constants.beam_radius_m));
}

/// How wide a beam is whose ray meets a surface at that distance, and where it begins and ends. False: it cannot be.
bool place_beam(inout Splat splat, uint caster, float hit_m) {
    const vec3 landing = splat.origin + hit_m * splat.axis;
    const float alone_m = beam_radius_m(landing, hit_m, caster, 1.0);
    splat.radius = constants.shrink * beam_radius_m(landing, hit_m, caster, splat.weight);
    if (!SPLAT_NORMALISED) splat.intensity /= sqr(splat.radius);
    if (!is_finite(splat.intensity)) return false;
    const float step_back_m = constants.beam_step_back_m + constants.beam_step_back_radii * alone_m;
    // Not before the whole bundle has left the surface it comes from, whose back would shadow it.
    const float cosine = max(abs(dot(splat.normal, splat.axis)), 1e-3);
    const float leaves_m = splat.radius * sqrt(max(1.0 - sqr(cosine), 0.0)) / cosine;
    splat.near_m = max(hit_m - step_back_m, min(leaves_m, hit_m));
    splat.far_m = max(hit_m - step_back_m + constants.beam_depth_m + constants.beam_depth_radii * alone_m, splat.near_m);
    return true;
}

/// False: it lights nothing.
bool make_splat(SplatSourceRecord source, uint ray, ReflectedPhotonRecord photon, inout uint photon_rays, out Splat splat) {
    const uint spread = photon.scatterings_and_spread >> SPREAD_SHIFT & 3u;
    const uint rays = spread == SPREAD_BEAM ? 1 : constants.rays_per_photon;
    if (ray >= rays) return false;
    RandomStream random = make_random_stream(constants.seed, RANDOM_DOMAIN_SPLATS, constants.pass, source.photon);
    const vec2 offset = random_stream_next_2d(random);
    random.key += ray * STREAM_STEP;
    splat.origin = photon.position;
    splat.axis = rays == 1 ? photon.direction : splat_direction(photon.normal, offset, ray);
    splat.normal = photon.normal;
    splat.weight = source.photons;
    splat.disc = kernel_sample_disc(constants.kernel, random_stream_next(random));
    splat.kind = (photon.scatterings_and_spread & 0xffu) << SPLAT_SCATTERINGS_SHIFT;
    splat.near_m = 0.0;
    splat.far_m = INFINITY;
    splat.smooth_normal = photon.smooth_normal;
    splat.correction = photon.correction;
    splat.surface = photon.surface;
    const bool connects = constants.connects != 0 && spread != SPREAD_BEAM;
    splat.radius = sqrt(source.photons);
    vec3 power_w = source.power_w / float(rays);
    if (!connects) {
        splat.kind |= SPLAT_BEAM;
        // ReflectedPhoton::correction_towards()
        if (spread == SPREAD_LAMBERT && photon.correction != 1.0 &&
            dot(octahedral_decode(16u, photon.smooth_normal), splat.axis) > 0.0)
            power_w *= photon.correction;
        // A colour, what the scene's surfaces would get on average if all photons were like this one, with the weight it
        // has in the mean.
        if (SPLAT_NORMALISED)
            splat.intensity = power_w * (splat.weight * float(rays) * constants.colour_scale);
        else
            splat.intensity = power_w;
    } else if (spread == SPREAD_ROUGH) {
        splat.kind |= SPLAT_CONNECT_ROUGH;
        const float own = max_component(photon.power_w);
        splat.intensity = surfaces[photon.surface].arriving_power_w * (own > 0.0 ? max_component(power_w) / own : 0.0);
    } else {
        splat.kind |= SPLAT_CONNECT | (photon.correction != 1.0 ? SPLAT_CORRECTED : 0u);
        splat.intensity = power_w;
    }
    if (is_black(splat.intensity) || !is_finite(splat.intensity)) return false;
    if (!SPLAT_HAS_BEAMS || connects) return true;
    const vec3 side = dot(splat.normal, splat.axis) < 0.0 ? -splat.normal : splat.normal;
    ++photon_rays;
    const Hit hit = closest_hit(Ray(offset_ray_origin(splat.origin, side), splat.axis, INFINITY));
    if (!hit_valid(hit)) return false;
    const uint caster = spread == SPREAD_BEAM ? photon.scatterings_and_spread >> CASTER_SHIFT : MOST_CASTER;
    return place_beam(splat, caster, hit.t);
}

void main() {
    const uint index = flat_index();
    if (index < push.splats) {
        const uint source = push.first_source + index / constants.rays_per_photon;
        uint photon_rays = 0;
        Splat splat;
        bool lights = false;
        if (source < (SPLAT_STRATIFIED ? push.end_source : min(push.end_source, state[REFLECTION_PHOTONS]))) {
            SplatSourceRecord of = SplatSourceRecord(source, vec3(0.0), 1.0);
            if (SPLAT_STRATIFIED) of = sources[source];
            const ReflectedPhotonRecord photon = photons[order[of.photon]];
            if (!SPLAT_STRATIFIED) of.power_w = photon.power_w;
            lights = make_splat(of, index % constants.rays_per_photon, photon, photon_rays, splat);
        }
        if (!lights) splat.kind = SPLAT_NONE;
        splats[index] = splat;
        count(COUNTER_PHOTON_RAYS, photon_rays);
        count(COUNTER_SPLATS, lights ? 1 : 0);
    }
}
