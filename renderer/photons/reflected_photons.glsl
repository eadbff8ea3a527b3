// GLSL twin of photons/photon_reflections.cpp: what light paths leave where they are reflected. Photons are
// appended as they come and know whose they are: how many each path left, summed, gives them an order that does not
// depend on that (photon_tracer's is another: batch by batch, by scatterings).
//
// Bindings 1 to 5 of set 0 are taken.
#ifndef PHOTOND_REFLECTED_PHOTONS_GLSL
#define PHOTOND_REFLECTED_PHOTONS_GLSL

#include "renderer/photons/photon.glsl"
#include "renderer/photons/photon_paths.glsl"
#include "renderer/photons/reflected_photon_shared.h"
#include "renderer/transport/roulette_shared.h"

layout(set = 0, binding = 1, scalar) buffer State { uint state[REFLECTION_STATE_WORDS]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Photons { ReflectedPhotonRecord photons[]; };
layout(set = 0, binding = 3, scalar) writeonly buffer Owners { PhotonOwner owners[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer PathCounts { uint photons_of_path[]; };
layout(set = 0, binding = 5, scalar) writeonly buffer Surfaces { ReflectingSurfaceRecord surfaces[]; };

/// Said once a shader.
struct ReflectionLimits {
    uint most_scatterings;
    uint photon_capacity;
    uint surface_capacity;
    float glossy_threshold;
    bool rough_apart;  // PhotonTracing's
    bool beams;
};
ReflectionLimits reflection;

uint kept = 0;  // of this path

void keep(uint path, ReflectedPhotonRecord photon) {
    const uint place = atomicAdd(state[REFLECTION_PHOTONS], 1u);
    if (place < reflection.photon_capacity) {
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

/// At a plain Lambert reflector one draw of roulette decides whether the photon is kept and the path goes on. False: it
/// ends.
bool reflect_lambert(uint number, PhotonVertex vertex, PhotonNumbers numbers, float most_survival, bool goes_on,
                     inout PhotonPath path, inout Ray ray) {
    const vec3 reflected = path.power_w * vertex.rough.diffuse;
    const float hope = max_component(reflected) * path.reference_inverse;
    const float survival = min(hope, most_survival);
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
    const float hope = flux_to_keep_by(path.power_w, albedo) * path.reference_inverse;
    const float kept_share = min(hope, 1.0);
    // The photon is kept where the number is large, the path goes on where the same number is small: where one is lost
    // the other is more likely there.
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
        if (photon.surface < reflection.surface_capacity)
            surfaces[photon.surface] = ReflectingSurfaceRecord(hit.t, hit.instance, hit.triangle, hit.u, hit.v,
                                                               vertex.wi_world, arriving_w, vertex.outside_ior);
    }
    keep(number, photon);
}

/// Any other surfaces. False: the path ends.
bool reflect_parted(uint number, PhotonVertex vertex, Hit hit, PhotonNumbers numbers, bool goes_on,
                    inout PhotonPath path, inout Ray ray) {
    const bool apart = reflection.rough_apart && bsdf_scatters(vertex.rough) &&
                       !bsdf_has_non_delta_transmission(vertex.rough);
    if (apart) keep_rough(number, vertex, hit, numbers, path);
    if (!goes_on && (!reflection.beams || (apart && !bsdf_scatters(vertex.specular)))) return false;
    bool is_rough;
    if (!scatter_parted(vertex, numbers, true, path, ray, is_rough)) return false;
    if (reflection.beams && !(apart && is_rough)) {
        ReflectedPhotonRecord photon;
        photon.position = vertex.point.position;
        photon.power_w = path.power_w;
        photon.normal = vertex.point.geometric_normal;
        photon.direction = ray.direction;
        photon.smooth_normal = octahedral_encode(16u, vertex.point.smooth_normal);
        photon.correction = 1.0;
        photon.surface = NO_SURFACE;
        photon.scatterings_and_spread = pack_spread(path.scatterings, SPREAD_BEAM) | min(hit.instance, MOST_CASTER) << CASTER_SHIFT;
        keep(number, photon);
    }
    return goes_on;
}

/// Follows a path to its end and keeps what it leaves. `first_survival`: the most that its first hit lets survive. The
/// number of its rays.
uint follow_reflections(uint number, SequenceKey sequence, uint64_t element, float first_survival, EmissionSample start,
                        PhotonPath path) {
    uint rays = 0;
    bool alive = true;
    Ray ray = start.ray;
    while (alive && path.scatterings < reflection.most_scatterings) {
        const bool goes_on = path.scatterings + 1 < reflection.most_scatterings;
        const Ray arriving = ray;
        Hit hit;
        PhotonVertex vertex;
        ++rays;
        alive = follow_photon(path, arriving, start.range_m, hit) &&
                part_hit(path, hit, arriving.direction, reflection.glossy_threshold, vertex);
        if (!alive) break;
        const PhotonNumbers numbers = photon_numbers(sequence, element, path.scatterings);
        const float most_survival = path.scatterings == 0 ? first_survival : ROULETTE_MOST_SURVIVAL;
        if (is_plain_lambert(vertex.point.material))
            alive = reflect_lambert(number, vertex, numbers, most_survival, goes_on, path, ray);
        else
            alive = reflect_parted(number, vertex, hit, numbers, goes_on, path, ray);
    }
    return rays;
}

/// After the path: how many photons it left.
void end_reflections(uint number) {
    photons_of_path[number] = kept;
    if (photon_nan_samples > 0) atomicAdd(state[REFLECTION_NAN_SAMPLES], photon_nan_samples);
    if (photon_infinite_samples > 0) atomicAdd(state[REFLECTION_INFINITE_SAMPLES], photon_infinite_samples);
}

#endif
