// V of virtual point lights by rays through the scene.
#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/many_lights/vpl.glsl"

bool vpl_visibility_asks() { return true; }
bool vpl_occluded(uint light, Vpl vpl, GBufferPoint point) {
    const vec3 origin = offset_ray_origin(point.position, lit_side(point, vpl.position));
    return occluded(Ray(origin, offset_ray_origin(vpl.position, vpl.normal) - origin, kConnectionEnd));
}
