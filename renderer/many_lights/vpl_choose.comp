#version 460
// The texels that light paths start at: keys to sort the paths by.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define FLUX_SUMS_BINDING 0
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/flux_map.glsl"
#include "renderer/many_lights/vpl_tracer_shared.h"
#include "renderer/photons/reflected_photon_shared.h"

layout(local_size_x = VPL_GROUP) in;
layout(push_constant, scalar) uniform Push { VplChoosePush push; };
layout(set = 0, binding = 1, scalar) writeonly buffer Texels { uint texel_of_path[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Places { uint places[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Paths { VplPath paths[]; };
layout(set = 0, binding = 4, scalar) readonly buffer State { uint state[REFLECTION_STATE_WORDS]; };

void main() {
    const uint i = flat_index();
    if (i >= min(push.paths, state[REFLECTION_PATHS])) return;
    const uvec2 point = uvec2(paths[i].point_x, paths[i].point_y);
    texel_of_path[i] = flux_total(push.levels) > 0.0 ? flux_choose(push.levels, point).index : 0u;
    places[i] = i;
}
