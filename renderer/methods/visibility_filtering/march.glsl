// The body of march.comp and march_svo.comp: sparse rays from the points that have lists, a thread a ray, and the first
// voxel in which each meets something [Chen 2014, section 3.1]. Before it come #version and the extensions, and
// FIRST_VOXEL(origin, normal, direction, out MetVoxel): false where it meets nothing.

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/frame/device_image_shared.h"
#include "renderer/gbuffer/receiver.glsl"
#include "renderer/many_lights/flux_map.glsl"
#include "renderer/methods/visibility_filtering/kept_lists_shared.h"
#include "renderer/methods/visibility_filtering/proxy_voxel.glsl"
#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"
#include "renderer/transport/sampling.glsl"

layout(constant_id = LISTS_ID) const uint LISTS = LISTS_COUNTS;
layout(constant_id = WORLD_RAYS_ID) const bool WORLD_RAYS = false;
layout(constant_id = KEEPS_LISTS_ID) const bool KEEPS_LISTS = false;

layout(local_size_x = LISTS_GROUP) in;
layout(push_constant, scalar) uniform Push { ListsPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer Constants { VisibilityConstants constants; };
layout(set = 0, binding = 1, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 2, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 3, scalar) buffer Lists { uint lists[]; };
#define COUNTERS_BINDING 4
#include "renderer/backends/gpu/counters.glsl"
layout(set = 0, binding = 10, scalar) writeonly buffer MetPlaces { vec3 met_places[]; };  // by ray, for the next frame
#define VISIBILITY constants
#include "renderer/methods/visibility_filtering/marching_points.glsl"
#include "renderer/methods/visibility_filtering/counted_voxel.glsl"

/// What a list's rays are turned by. Tied to the world, places that are near one another on surfaces that face alike have
/// the same, wherever they are seen from and whatever the job's seed, so that frames of an animation have them too.
uint rays_key(GBufferPoint point) {
    if (!WORLD_RAYS) return hash32(point.pixel ^ constants.key);
    const vec3 n = point.geometric_normal;
    // Surfaces lie on the walls of cells where a scene is built by round numbers: rounding would scatter them on both sides.
    const float off_wall = 0.381966;
    const ivec3 cell = ivec3(floor(point.position / constants.world_cell_m + off_wall * n));
    const uint octant = uint(n.x < 0.0) | uint(n.y < 0.0) << 1 | uint(n.z < 0.0) << 2;
    return hash32(uint(cell.x) ^ hash32(uint(cell.y) ^ hash32(uint(cell.z) ^ hash32(octant ^ constants.world_key))));
}

/// Of ray i, by the cosine; half of those that leave what is not Lambert may go where it reflects. False: nothing is sent
/// there.
bool ray_direction(GBufferPoint point, uint index, uint i, out vec3 direction) {
    const uint key = rays_key(point);
    const uvec2 bits = rotated_halton_point(i, uvec2(key, hash32(key)));
    const vec2 u = vec2(to_unit_float(bits.x), to_unit_float(bits.y));
    const bool by_gloss = LISTS != LISTS_COUNTS && i % 2u == 1u;  // counts tell of all directions alike
    if (is_general(point) && (by_gloss || point.normal == vec3(0.0))) {
        const Receiver receiver = make_receiver(general_points[index], constants.glossy_threshold);
        const BsdfSample next =
            bsdf_sample(receiver.rough, receiver.wo, to_unit_float(hash32(key ^ hash32(i))), u, TRANSPORT_RADIANCE);
        direction = to_world(receiver.surface.shading, next.wi);
        return bsdf_sample_valid(next);
    }
    direction = to_world(make_frame(point.normal), sample_cosine_hemisphere(u));
    return dot(direction, point.geometric_normal) > 0.0;
}

/// False: the ray meets nothing, `met.place` is then a direction's (far_place()), or there is no ray.
bool trace_ray(GBufferPoint point, uint index, uint ray, out MetVoxel met) {
    vec3 direction;
    met = MetVoxel(0u, false, NO_PLACE);
    if (!is_lit(point) || !ray_direction(point, index, ray, direction)) return false;
    count(COUNTER_SHADOW_RAYS, 1);
    if (FIRST_VOXEL(point.position, side_towards(point, direction), direction, met)) return true;
    met.place = far_place(direction);
    return false;
}

void main() {
    const uint thread = push.first * constants.rays + flat_index();
    const uint list = thread / constants.rays, ray = thread % constants.rays;
    if (list >= push.end) return;
    const uint index = marching_point(list);
    MetVoxel met;
    const bool any_met = trace_ray(points[index], index, ray, met);
    if (KEEPS_LISTS) met_places[thread] = met.place;
    if (any_met) count_voxel(list, met);
}
