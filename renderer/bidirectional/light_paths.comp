#version 460
// Light paths, the vertices they leave and what the camera sees of them: a thread follows a path to its end, then takes
// the next one. CPU twin: light_paths.cpp, with the same numbers. Vertices are appended as they come, under a key by
// which they are sorted into the twin's order; what the camera sees of one stands at the vertex's own place.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require

#define EYE_BINDING 0
#define BIDIRECTIONAL_BINDING 1
#define LIGHT_TABLES_BINDING 9
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/bidirectional/bidirectional.glsl"
#include "renderer/eye/camera_connection.glsl"
#include "renderer/eye/eye_scene.glsl"
#include "renderer/photons/photon_paths.glsl"

layout(local_size_x = LIGHT_PATHS_GROUP) in;
layout(push_constant, scalar) uniform Push { LightPathsPush push; };
layout(set = 0, binding = 2, scalar) buffer State { uint state[LIGHT_STATE_WORDS]; };
layout(set = 0, binding = 3, std430) writeonly buffer Places { uvec4 places[]; };  // position, and its own number
layout(set = 0, binding = 4, scalar) writeonly buffer Vertices { LightVertexRecord vertices[]; };
layout(set = 0, binding = 5, scalar) writeonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 6, scalar) writeonly buffer Order { uint order[]; };
layout(set = 0, binding = 7, std430) writeonly buffer SplatPlaces { uvec4 splat_places[]; };  // film [pixels]
layout(set = 0, binding = 8, scalar) writeonly buffer Splats { LightSplatRecord splats[]; };

uint light_rays = 0, shadow_rays = 0;

/// A path between two of its vertices, and what it is to be told from others by.
struct LightWalk {
    vec3 power_w;
    float reference_inverse;  // [1/W] of the greatest component at emission: roulette keeps the power near that
    SubpathWeights weights;
    Ray ray;
    MediumStack media;
    uint surfaces;  // met so far
    bool all_delta;
    // Of its light, for the first hit.
    bool infinite;
    uint light;
    float range_m;
    uint number;  // of the pass
};

uint64_t element_of(uint number) { return push.first_element + uint64_t(number); }

/// False: it carries nothing.
bool start_walk(uint number, out LightWalk walk) {
    EmissionSample start;
    const bool drawn = draw_emission(push.sequence, element_of(number), start);
    walk.number = number;
    if (!drawn || is_black(start.power_w)) return false;
    const LightEnd end = light_end_of_emission(start);
    if (!(end.emission > 0.0)) return false;
    walk.power_w = start.power_w / float(techniques.light_paths);
    walk.reference_inverse = 1.0 / max_component(walk.power_w);
    walk.weights = mis_start_light(end);
    walk.ray = start.ray;
    walk.media = make_medium_stack();
    walk.surfaces = 0;
    walk.all_delta = true;
    walk.infinite = end.infinite;
    walk.light = start.light;
    walk.range_m = start.range_m;
    return true;
}

/// By run, then by surfaces, then by path: the order in which the twin finds them, batch after batch.
uint key_of(LightWalk walk) {
    if (push.surface_bits == 0) return walk.number;
    const uint64_t element = element_of(walk.number);
    const uint run = uint((element >> LIGHT_RUN_BITS) - (push.first_element >> LIGHT_RUN_BITS));
    const uint surfaces = min(walk.surfaces, (1u << push.surface_bits) - 1u);
    return ((run << push.surface_bits | surfaces) << LIGHT_RUN_BITS) | (uint(element) & ((1u << LIGHT_RUN_BITS) - 1u));
}

/// PixelFilterSampler::reaches_image().
bool reaches_image(vec2 film) {
    const float margin = eye.smooth_filter != 0 ? FILTER_RADIUS - 0.5 : 0.0;
    return film.x >= -margin && film.y >= -margin && film.x < float(eye.width) + margin &&
           film.y < float(eye.height) + margin;
}

/// What the camera sees of the vertex: where in the film, and how bright a pixel. False: nothing.
bool show_camera(SurfaceVertex vertex, LightWalk walk, float acceptance, out vec2 film, out vec3 radiance) {
    vec2 lens = vec2(0.0);
    if (eye.camera.aperture_radius_m > 0.0)
        lens = sequence_sample_2d(push.sequence, element_of(walk.number), FIRST_LENS_SET + walk.surfaces);
    CameraConnection seen;
    if (!camera_connect(eye.camera, vertex.point.position, lens, seen) || !reaches_image(seen.film)) return false;
    film = seen.film;
    const LightScattering scattering = scatter_to_eye(vertex, seen.to_camera);
    if (is_black(scattering.density)) return false;
    const float cosine = abs(dot(vertex.point.geometric_normal, seen.to_camera));
    const VertexSide side = VertexSide(walk.surfaces == 1, scattering.eye_pdf, acceptance);
    radiance = seen.responsivity_per_m2 * walk.power_w * scattering.density *
               mis_seen_by_camera(walk.weights, side, seen.responsivity_per_m2 * cosine, techniques.numbers);
    if (is_black(radiance)) return false;
    const vec3 start = ray_origin(vertex.point, seen.to_camera);
    ++shadow_rays;
    return !occluded(Ray(start, seen.target - start, 1.0));
}

void store(LightWalk walk, SurfaceVertex vertex, float outside_ior, float acceptance) {
    const uint place = atomicAdd(state[LIGHT_VERTICES_WORD], 1u);
    if (place >= techniques.capacity) return;
    vec2 film;
    vec3 radiance;
    const bool seen = show_camera(vertex, walk, acceptance, film, radiance);
    LightVertexRecord record;
    record.position = vertex.point.position;
    record.normal = vertex.point.geometric_normal;
    record.instance = vertex.point.instance;
    record.from = vertex.from;
    record.triangle = vertex.point.triangle;
    record.power_w = walk.power_w;
    record.outside_ior = outside_ior;
    record.weights = walk.weights;
    record.u = vertex.point.u, record.v = vertex.point.v;
    record.acceptance = acceptance;
    record.surfaces = walk.surfaces | (walk.all_delta ? LIGHT_VERTEX_ALL_DELTA : 0u);
    vertices[place] = record;
    places[place] = uvec4(floatBitsToUint(vertex.point.position), place);
    keys[place] = key_of(walk);
    order[place] = place;
    // Where nothing is seen: beyond the film, in cells that no pixel looks into.
    splat_places[place] = uvec4(floatBitsToUint(seen ? film : vec2(INFINITY)), 0u, place);
    const bool caustic = walk.surfaces > 1 && walk.all_delta;
    splats[place] =
        LightSplatRecord(seen ? radiance : vec3(0.0), walk.surfaces | (caustic ? LIGHT_SPLAT_CAUSTIC : 0u));
}

/// False: the path ends.
bool go_on(SurfaceVertex vertex, float acceptance, inout LightWalk walk) {
    const PhotonNumbers numbers = photon_numbers(push.sequence, element_of(walk.number), walk.surfaces - 1);
    const PhotonScattering next =
        scatter_photon(vertex.point, vertex.bsdf, vertex.from, numbers.choice.y, numbers.direction);
    if (!photon_scattering_valid(next)) return false;
    const vec3 power_w = walk.power_w * next.weight;
    const float survival = min(max_component(power_w) * walk.reference_inverse, ROULETTE_MOST_SURVIVAL);
    if (!(numbers.choice.x < survival)) return false;
    walk.power_w = power_w / survival;
    walk.all_delta = walk.all_delta && next.delta;
    const float cos_out = abs(dot(vertex.point.geometric_normal, next.direction));
    if (next.delta)
        mis_scatter_delta(walk.weights, cos_out);
    else
        mis_scatter(walk.weights,
                    VertexSide(walk.surfaces == 1, eye_pdf_back(vertex, next.direction), acceptance), next.pdf_sa,
                    cos_out);
    if (next.refraction) medium_stack_cross(walk.media, vertex.point.material, vertex.point.front_side);
    walk.ray = Ray(ray_origin(vertex.point, next.direction), next.direction, INFINITY);
    return true;
}

/// To the next surface, what is left there, and on. False: the path ends.
bool step_walk(inout LightWalk walk) {
    ++light_rays;
    const Hit hit = closest_hit(walk.ray);
    if (!hit_valid(hit)) return false;
    ++walk.surfaces;
    const bool first = walk.surfaces == 1;
    SurfaceVertex vertex;
    vertex.point = make_shading_point(hit, walk.ray.direction);
    vertex.from = -walk.ray.direction;
    const uint material = vertex.point.material;
    if (NEEDS_UNLIT && has_flag(scene_materials[material].flags, MATERIAL_UNLIT)) return false;
    if (first && walk.range_m < INFINITY) walk.power_w *= range_window(hit.t, walk.range_m);
    walk.power_w *= transmittance(walk.media, hit.t);
    const float cosine = dot(vertex.point.geometric_normal, vertex.from);
    if (is_black(walk.power_w) || !(cosine > 0.0)) return false;
    const float outside_ior = medium_stack_outside_ior(walk.media, material, !vertex.point.front_side);
    vertex.bsdf = make_bsdf(vertex.point, outside_ior);
    if (first) {
        const EmissionSample start = EmissionSample(walk.ray, vec3(0.0), walk.light, 0u, walk.range_m);
        mis_direct_at_first_hit(walk.weights, light_direct_at_first_hit(start, vertex.point.position,
                                                                        lit_normal_of(vertex), hit.t));
    }
    mis_arrive(walk.weights, first && walk.infinite ? 1.0 : sqr(hit.t), cosine);
    float acceptance = 0.0;
    if (bsdf_has_non_delta(vertex.bsdf)) {
        acceptance = merge_acceptance(vertex.point.position, !first && walk.all_delta);
        store(walk, vertex, outside_ior, acceptance);
    }
    if (walk.surfaces >= eye.max_scatterings) return false;
    return go_on(vertex, acceptance, walk);
}

void add_rays(uint word, uint of_thread) {
    const uint rays = subgroupAdd(of_thread);
    if (!subgroupElect() || rays == 0) return;
    const uint before = atomicAdd(state[word], rays);
    if (before + rays < before) atomicAdd(state[word + 1], 1u);  // the carry
}

void main() {
    LightWalk walk;
    uint next = push.first_path + flat_index();
    bool alive = false;
    while (true) {
        while (!alive && next < push.end_path) {
            alive = start_walk(next, walk);
            next = push.first_path + push.threads + atomicAdd(state[LIGHT_NEXT_PATH_WORD], 1u);
        }
        if (!alive) break;
        alive = step_walk(walk);
    }
    add_rays(LIGHT_RAYS_WORD, light_rays);
    add_rays(LIGHT_SHADOW_RAYS_WORD, shadow_rays);
}
