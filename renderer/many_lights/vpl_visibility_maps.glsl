// V of virtual point lights by a depth map each. `constants`: the VplLightingConstants.
#define VPL_MAPS_BINDING VPL_VISIBILITY_BINDING
#include "renderer/many_lights/vpl_shadow_maps.glsl"

bool vpl_visibility_asks() { return true; }
bool vpl_occluded(uint light, Vpl vpl, GBufferPoint point) {
    return vpl_map_occluded(light, vpl.position, make_frame(vpl.normal), point.position, constants.map_resolution);
}
