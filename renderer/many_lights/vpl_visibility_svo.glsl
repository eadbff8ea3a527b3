// V of virtual point lights by the voxels between: all of them, or those near the point. `constants`: the
// VplLightingConstants.
#define SVO_CONSTANTS_BINDING VPL_VISIBILITY_BINDING
#define SVO_NODES_BINDING VPL_VISIBILITY_BINDING + 1
#define SVO_BRICKS_BINDING VPL_VISIBILITY_BINDING + 2
#include "renderer/voxels/svo_march.glsl"

bool vpl_visibility_asks() { return true; }
bool vpl_occluded(uint light, Vpl vpl, GBufferPoint point) {
    return svo_occluded(point.position, lit_side(point, vpl.position), vpl.position, vpl.normal,
                        constants.voxel_reach_m);
}
