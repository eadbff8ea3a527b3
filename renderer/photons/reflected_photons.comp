#version 460
// Light paths and what they leave where they are reflected, a thread a path, with the same numbers as CPU twin
// photon_wavefront_reflections.cpp. Photons are appended as they come and know whose they are: how many each path left,
// summed, gives them an order that does not depend on that (photon_tracer's is another: batch by batch, by scatterings).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/counters.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/photons/photon.glsl"
#include "renderer/photons/photon_paths.glsl"
#include "renderer/photons/reflected_photon_shared.h"

layout(local_size_x = REFLECTION_GROUP) in;
layout(push_constant, scalar) uniform Push { ReflectionPush push; };
layout(set = 0, binding = 1, scalar) buffer State { uint state[REFLECTION_STATE_WORDS]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Photons { ReflectedPhotonRecord photons[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Owners { PhotonOwner owners[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer PathCounts { uint photons_of_path[]; };
layout(set = 0, binding = 5, scalar) writeonly buffer Surfaces { ReflectingSurfaceRecord surfaces[]; };
layout(set = 0, binding = 6, scalar) readonly buffer Grids { TexelGrid grids[]; };

const float LEAST_ROUGH_SHARE = 1.0 / 16;  // kLeastRoughShare

uint kept = 0;  // of this path

void keep(uint path, ReflectedPhotonRecord photon) {
    const uint place = atomicAdd(state[REFLECTION_PHOTONS], 1u);
    if (place < push.photon_capacity) {
        photons[place] = photon;
        owners[place] = PhotonOwner(path, kept);
    }
    ++kept;
}

uint pack_spread(uint scatterings, uint spread) { return min(scatterings, 255u) | spread << SPREAD_SHIFT; }

/// The photon's smooth normal, and |cos_s| / |cos_g| of the arriving direction in front of it.
void set_smooth_normal(inout ReflectedPhotonRecord photon, vec3 smooth_normal, vec3 wi_world) {
    photon.smooth_normal = octahedral_encode(16u, smooth_normal);
    if (smooth_normal == photon.normal) return;
    photon.correction = max(dot(smooth_normal, wi_world), 0.0) / dot(photon.normal, wi_world);
}

void count_nan(float hope) {
    if (isnan(hope)) ++photon_nan_samples;
}

/// is_plain_lambert() of lambert_lanes.h.
bool is_plain_lambert(uint material) {
    return ONLY_LAMBERT ||
           (scene_materials[material].metallic == 0.0 && scene_materials[material].specular == 0.0 &&
            scene_materials[material].transmission == 0.0 &&
            !texture_used(scene_materials[material].normal_texture));
}

/// At plain Lambert reflectors: what lets the path go on keeps the photon. False: it ends.
bool reflect_lambert(uint number, PhotonVertex vertex, PhotonNumbers numbers, bool goes_on, inout PhotonPath path,
                     inout Ray ray) {
    const vec3 reflected = path.power_w * vertex.rough.diffuse;
    const float hope = max_component(reflected) * path.reference_inverse;
    const float survival = min(hope, MOST_SURVIVAL);
    if (!(numbers.choice.x < survival)) {
        count_nan(hope);
        return false;
    }
    ReflectedPhotonRecord photon;
    photon.position = vertex.point.position;
    photon.power_w = reflected * (1.0 / survival);
    photon.normal = vertex.point.geometric_normal;
    photon.direction = to_world(make_frame(photon.normal), sample_cosine_hemisphere(numbers.direction));
    photon.correction = 1.0;
    photon.surface = NO_SURFACE;
    photon.scatterings_and_spread = pack_spread(path.scatterings + 1, SPREAD_LAMBERT);
    set_smooth_normal(photon, vertex.point.smooth_normal, vertex.wi_world);
    if (!is_sound(photon.power_w) || !is_sound(photon.power_w * photon.correction)) return false;
    keep(number, photon);
    if (!goes_on || !(dot(photon.normal, photon.direction) > 0.0)) return false;
    const float correction = dot(vertex.point.smooth_normal, photon.direction) > 0.0 ? photon.correction : 1.0;
    path.power_w = photon.power_w * correction;
    if (correction == 0.0 || !is_sound(path.power_w)) return false;
    ++path.scatterings;
    path.rough = true;
    path.all_delta = false;
    ray = Ray(offset_ray_origin(photon.position, photon.normal), photon.direction, INFINITY);
    return true;
}

/// All that the rough part scatters, whatever direction the path will take: kept with a probability that does not depend
/// on the direction.
void keep_rough(uint number, PhotonVertex vertex, Hit hit, PhotonNumbers numbers, PhotonPath path) {
    const vec3 albedo = bsdf_albedo(vertex.rough);
    const float hope = max(max_component(path.power_w * albedo), LEAST_ROUGH_SHARE * max_component(path.power_w)) *
                       path.reference_inverse;
    const float kept_share = min(hope, 1.0);
    // By the upper end of the number whose lower end the path goes on by: photons and paths make up for one another.
    if (!(numbers.choice.x >= 1.0 - kept_share)) {
        count_nan(hope);
        return;
    }
    const vec3 arriving_w = path.power_w / kept_share;
    const bool lambert = bsdf_is_lambert(vertex.rough);
    ReflectedPhotonRecord photon;
    photon.position = vertex.point.position;
    photon.power_w = arriving_w * albedo;
    photon.normal = vertex.point.geometric_normal;
    photon.direction = to_world(make_frame(photon.normal), sample_cosine_hemisphere(numbers.direction));
    photon.correction = 1.0;
    photon.surface = NO_SURFACE;
    photon.scatterings_and_spread = pack_spread(path.scatterings + 1, lambert ? SPREAD_LAMBERT : SPREAD_ROUGH);
    if (lambert)
        set_smooth_normal(photon, vertex.point.smooth_normal, vertex.wi_world);
    else
        photon.smooth_normal = octahedral_encode(16u, vertex.point.smooth_normal);
    if (!is_sound(arriving_w) || !is_sound(photon.power_w * photon.correction)) return;
    if (!lambert) {
        photon.surface = atomicAdd(state[REFLECTION_SURFACES], 1u);
        if (photon.surface < push.surface_capacity)
            surfaces[photon.surface] = ReflectingSurfaceRecord(hit.t, hit.instance, hit.triangle, hit.u, hit.v,
                                                               vertex.wi_world, arriving_w, vertex.outside_ior);
    }
    keep(number, photon);
}

/// Any other surfaces. False: the path ends.
bool reflect_parted(uint number, PhotonVertex vertex, Hit hit, PhotonNumbers numbers, bool goes_on,
                    inout PhotonPath path, inout Ray ray) {
    const bool apart = push.rough_apart != 0 && bsdf_scatters(vertex.rough) &&
                       !bsdf_has_non_delta_transmission(vertex.rough);
    if (apart) keep_rough(number, vertex, hit, numbers, path);
    if (apart && !goes_on && !bsdf_scatters(vertex.specular)) return false;
    bool is_rough;
    if (!scatter_parted(vertex, numbers, true, path, ray, is_rough)) return false;
    if (!(apart && is_rough)) {
        ReflectedPhotonRecord photon;
        photon.position = vertex.point.position;
        photon.power_w = path.power_w;
        photon.normal = vertex.point.geometric_normal;
        photon.direction = ray.direction;
        photon.smooth_normal = octahedral_encode(16u, vertex.point.smooth_normal);
        photon.correction = 1.0;
        photon.surface = NO_SURFACE;
        photon.scatterings_and_spread = pack_spread(path.scatterings, SPREAD_BEAM);
        keep(number, photon);
    }
    return goes_on;
}

/// Twin: ReflectiveShadowMapPass::sample().
bool start_at_texel(uint texel, uint64_t element, out EmissionSample start) {
    uint low = 0, high = push.grids;  // the last grid whose first texel is at or before this one
    while (high - low > 1) {
        const uint middle = (low + high) / 2;
        if (grids[middle].first_texel <= texel) low = middle; else high = middle;
    }
    const TexelGrid grid = grids[low];
    const uint place = texel - grid.first_texel;
    const vec2 u_jitter = sequence_sample_2d(push.sequence, element, JITTER_SET);
    vec2 u_position = sequence_sample_2d(push.sequence, element, PHOTON_SET_POSITION);
    vec2 u_direction = sequence_sample_2d(push.sequence, element, PHOTON_SET_DIRECTION);
    const vec2 cell = vec2(place % grid.columns, place / grid.columns);  // into_cell() of emission_grid.h
    const vec2 in_cell = min((cell + u_jitter) * (1.0 / vec2(grid.columns, grid.rows)), vec2(BELOW_ONE));
    if (emission_guided_by_position(grid.light)) u_position = in_cell; else u_direction = in_cell;
    return sample_emission_light(grid.light, grid.expected, u_position, u_direction, start);
}

void trace_path(uint number) {
    const uint64_t element = push.first_element + uint64_t(number);
    EmissionSample start;
    const bool carries =
        push.grids > 0 ? start_at_texel(number, element, start) : draw_emission(push.sequence, element, start);
    PhotonPath path;
    uint rays = 0;
    bool alive = carries && start_photon_path(start, push.share, path);
    Ray ray = start.ray;
    while (alive && path.scatterings < push.most_scatterings) {
        const bool goes_on = path.scatterings + 1 < push.most_scatterings;
        const Ray arriving = ray;
        Hit hit;
        PhotonVertex vertex;
        ++rays;
        alive = follow_photon(path, arriving, start.range_m, hit) &&
                part_hit(path, hit, arriving.direction, push.glossy_threshold, vertex);
        if (!alive) break;
        const PhotonNumbers numbers = photon_numbers(push.sequence, element, path.scatterings);
        if (is_plain_lambert(vertex.point.material))
            alive = reflect_lambert(number, vertex, numbers, goes_on, path, ray);
        else
            alive = reflect_parted(number, vertex, hit, numbers, goes_on, path, ray);
    }
    count(COUNTER_PHOTON_RAYS, rays);
    count(COUNTER_PHOTONS_EMITTED, 1);
    count(COUNTER_PHOTONS_STORED, kept);
}

void main() {
    const uint number = push.first_path + flat_index();
    if (number < push.end_path) {
        trace_path(number);
        photons_of_path[number] = kept;
        if (photon_nan_samples > 0) atomicAdd(state[REFLECTION_NAN_SAMPLES], photon_nan_samples);
        if (photon_infinite_samples > 0) atomicAdd(state[REFLECTION_INFINITE_SAMPLES], photon_infinite_samples);
    }
}
