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

float svo_plane_of(uint number, vec3 position, out vec3 normal) {
    const uvec2 place = svo_triangle(number, svo_constants.instance_count);
    const TriangleCorners corners = world_triangle(place.x, place.y);
    normal = svo_unit_normal(corners);
    return dot(normal, position - corners.p[0]);
}

/// The plane of a surface that a point in a set voxel lies on: unit normal and the point's signed distance. False: it lies
/// in no set voxel.
bool svo_plane_at(vec3 position, out vec3 normal, out float height) {
    const float cell_m = svo_constants.grid.cell_m;
    normal = vec3(0.0), height = 0.0;
    const uint own = svo_surface_at(position);
    if (own == SVO_NO_DATA) return false;
    height = svo_plane_of(own, position, normal);
    for (int i = 0; i < 6; ++i) {
        const float aside = (i & 1) != 0 ? cell_m : -cell_m;
        const vec3 beside = position + vec3(i < 2 ? aside : 0.0, i >= 2 && i < 4 ? aside : 0.0, i >= 4 ? aside : 0.0);
        const uint number = svo_surface_at(beside);
        if (number == SVO_NO_DATA || number == own) continue;
        vec3 n;
        const float distance = svo_plane_of(number, position, n);
        if (!(abs(distance) <= SVO_ON_PLANE * cell_m) || !(abs(distance) < abs(height))) continue;
        normal = n, height = distance;
    }
    return true;
}

/// Where to start asking of a ray's end, `along` leading into the ray.
vec3 svo_away_from_surface(vec3 position, vec3 along) {
    vec3 n;
    float height;
    if (!svo_plane_at(position, n, height)) return position;
    const float slope = dot(n, along);
    const bool off = abs(height) > SVO_ON_PLANE * svo_constants.grid.cell_m;
    if (off && height * slope < 0.0) return position;
    return svo_lift(position, slope < 0.0 ? -n : n);
}

Hit svo_closest_hit(Ray ray) {
    const float kVoxelDiagonal = 1.7321;  // its length
    const float kReach = 8.0;  // lifts, voxel diagonals: how far along the ray its plane may be from the voxel
    const float kLeastDistance = 1e-3;    // voxels
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
    // The voxel is that of the lifted ray, the point that of the ray itself, which meets the plane elsewhere.
    const float enter = skipped + t, margin = kReach * length(from - ray.origin);
    const float nearest = max(enter - margin, kLeastDistance * cell_m);
    const float farthest = max(enter + margin + kReach * kVoxelDiagonal * cell_m, nearest);
    const float slope = dot(n, along);
    const float distance =
        slope != 0.0 ? clamp(dot(n, corners.p[0] - ray.origin) / slope, nearest, farthest) : max(enter, nearest);
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
