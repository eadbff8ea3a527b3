// What shaders have in common that ask the lights chosen for points: a thread a point.
#include "renderer/backends/gpu/invocation.glsl"
#define COUNTERS_BINDING 0
#include "renderer/backends/gpu/counters.glsl"
#define VPL_LOBES_BINDING 6
#include "renderer/methods/vpl_choice_shared.h"
#include "renderer/methods/vpl_lighting.glsl"

layout(local_size_x = SPLIT_GROUP) in;
layout(push_constant, scalar) uniform Push { VplChoicePush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Constants { VplLightingConstants constants; };
layout(set = 0, binding = 2, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 3, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 5, scalar) readonly buffer Vpls { Vpl vpls[]; };
layout(set = 0, binding = 7, scalar) buffer Sums { vec3 sums[]; };
layout(set = 0, binding = CHOSEN_BINDING, scalar) readonly buffer Chosen { ChosenVplRecord chosen[]; };
layout(set = 0, binding = CHOSEN_COUNTS_BINDING, scalar) readonly buffer ChosenCounts { uint chosen_counts[]; };
