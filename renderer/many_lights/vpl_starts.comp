#version 460
// The first steps of the light paths of chosen texels, a thread a path, in the order of their texels or of their list.
// CPU twin: VplTracer::trace(). Apart from the paths, which have not enough buffers for both.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define TEXEL_RUNS_BINDING 0
#define FLUX_SUMS_BINDING 1
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/flux_map.glsl"
#include "renderer/photons/reflected_photon_shared.h"
#include "renderer/photons/texel_map.glsl"
#include "renderer/many_lights/vpl_tracer_shared.h"

layout(local_size_x = VPL_GROUP) in;
layout(push_constant, scalar) uniform Push { VplStartsPush push; };
layout(set = 0, binding = 2, scalar) readonly buffer Flux { float flux_w[]; };  // of texels, by the plain pyramid
layout(set = 0, binding = 3, scalar) readonly buffer Places { uint places[]; };  // in the list, by texel
layout(set = 0, binding = 4, scalar) writeonly buffer Starts { VplStart starts[]; };
layout(set = 0, binding = 5, scalar) readonly buffer Paths { VplPath paths[]; };
layout(set = 0, binding = 6, scalar) readonly buffer State { uint state[REFLECTION_STATE_WORDS]; };

VplStart first_step(VplPath path) {
    VplStart start = VplStart(vec3(0.0), vec3(0.0), vec3(0.0), INFINITY, 0.0, path.element);
    if (!(flux_total(push.levels) > 0.0)) return start;
    const Texel texel = flux_choose(push.levels, uvec2(path.point_x, path.point_y));
    EmissionSample emission;
    if (!start_at_texel(texel.index, push.runs, push.sequence, emission)) return start;
    const float share = path.weight / (float(push.vpls) * texel.probability);
    start.origin = emission.ray.origin;
    start.direction = emission.ray.direction;
    start.power_w = emission.power_w * share;
    start.range_m = emission.range_m;
    start.reflected_w = flux_w[texel.index] * share;
    return start;
}

void main() {
    const uint number = flat_index();
    if (number >= min(push.paths, state[REFLECTION_PATHS])) return;
    starts[number] = first_step(paths[push.first_path + (push.sorted != 0u ? places[number] : number)]);
}
