// GLSL twin of voxels/voxel_intersector.h: rays answered by a voxel tree, with its bias. Define what svo_march.glsl asks
// for, SVO_SURFACES_BINDING among it, and SVO_FIRST_TRIANGLES_BINDING (of set 0) before.
#ifndef PHOTOND_SVO_HIT_GLSL
#define PHOTOND_SVO_HIT_GLSL

#include "renderer/backends/gpu/bvh.glsl"  // Hit
#include "renderer/voxels/svo_march.glsl"
#include "renderer/voxels/svo_triangles.glsl"

vec2 svo_cut_barycentrics(TriangleCorners c, vec3 p) {
    const vec3 e1 = c.p[1] - c.p[0], e2 = c.p[2] - c.p[0], w = p - c.p[0];
    const float d11 = dot(e1, e1), d12 = dot(e1, e2), d22 = dot(e2, e2);
    const float w1 = dot(w, e1), w2 = dot(w, e2), determinant = d11 * d22 - d12 * d12;
    vec2 uv = vec2(0.0);
    if (determinant > 0.0)
        uv = vec2(d22 * w1 - d12 * w2, d11 * w2 - d12 * w1) / determinant;
    else if (d11 > 0.0)
        uv.x = w1 / d11;
    uv = max(uv, vec2(0.0));
    return uv / max(1.0, uv.x + uv.y);
}

vec3 svo_unit_normal(TriangleCorners c) {
    const vec3 n = cross(c.p[1] - c.p[0], c.p[2] - c.p[0]);
    const float size = length(n);
    return size > 0.0 ? n / size : vec3(0.0);
}

/// Where to start asking of a ray's end, `along` leading into the ray.
vec3 svo_away_from_surface(vec3 position, vec3 along) {
    const float kOnPlane = 0.1;  // voxels
    const float cell_m = svo_constants.grid.cell_m;
    const uint number = svo_surface_at(position);
    if (number == SVO_NO_DATA) return position;
    const uvec2 place = svo_triangle(number, svo_constants.instance_count);
    const TriangleCorners corners = world_triangle(place.x, place.y);
    vec3 n = svo_unit_normal(corners);
    if (!(abs(dot(n, position - corners.p[0])) <= kOnPlane * cell_m) || n == vec3(0.0))
        return position + SVO_BLIND_PULL_IN * cell_m * along;
    if (dot(n, along) < 0.0) n = -n;
    return svo_lift(position, n) + SVO_PULL_IN * cell_m * along;
}

Hit svo_closest_hit(Ray ray) {
    const float kVoxelDiagonal = 1.7321;  // its length
    const Hit none = Hit(INFINITY, NO_HIT, 0u, 0.0, 0.0);
    const float size = length(ray.direction), cell_m = svo_constants.grid.cell_m;
    if (!(ray.t_max > 0.0) || !(size > 0.0)) return none;
    const vec3 along = ray.direction / size;
    const vec3 from = svo_away_from_surface(ray.origin, along);
    const float skipped = max(dot(from - ray.origin, along), 0.0), reach = ray.t_max * size;
    float t;
    uvec3 voxel;
    uint number;
    if (!(skipped < reach) || !svo_first_voxel(Ray(from, along, reach - skipped), t, voxel, number)) return none;

    const uvec2 place = svo_triangle(number, svo_constants.instance_count);
    const TriangleCorners corners = world_triangle(place.x, place.y);
    const vec3 n = svo_unit_normal(corners);
    const float enter = skipped + t, leave = enter + kVoxelDiagonal * cell_m;
    const float slope = dot(n, along);
    const float distance = slope != 0.0 ? clamp(dot(n, corners.p[0] - ray.origin) / slope, enter, leave) : enter;
    const float t_hit = distance / size;
    if (!(t_hit > 0.0) || !(t_hit < ray.t_max)) return none;
    const vec2 uv = svo_cut_barycentrics(corners, ray.origin + distance * along);
    return Hit(t_hit, place.x, place.y, uv.x, uv.y);
}

/// Whether anything lies in (0, ray.t_max), by the tree.
bool svo_ray_occluded(Ray ray) {
    const float size = length(ray.direction);
    if (!(ray.t_max > 0.0) || !(size > 0.0)) return false;
    const vec3 along = ray.direction / size;
    const vec3 from = svo_away_from_surface(ray.origin, along);
    float t;
    uvec3 voxel;
    uint number;
    if (!is_finite(ray.t_max)) return svo_first_voxel(Ray(from, along, INFINITY), t, voxel, number);
    const vec3 to = svo_away_from_surface(ray.origin + ray.t_max * ray.direction, -along);
    if (!(dot(to - from, along) > 0.0)) return false;  // nearer to each other than they were moved
    const float left = length(to - from);
    return svo_first_voxel(Ray(from, (to - from) / left, left), t, voxel, number);
}

#endif
