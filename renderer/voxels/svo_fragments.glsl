// A thread a fragment, into the nodes that are built: what the passes over fragments read.
#ifndef PHOTOND_SVO_FRAGMENTS_GLSL
#define PHOTOND_SVO_FRAGMENTS_GLSL

#define DEVICE_TILES_BINDING 0
#define SVO_BUILD_NODES_BINDING 2
#define SVO_BUILD_READS_NODES
#include "renderer/backends/gpu/device_tiles.glsl"
#include "renderer/voxels/svo_build.glsl"

layout(local_size_x = SVO_GROUP) in;
layout(push_constant, scalar) uniform Push { SvoBuildPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer Fragments { SvoFragment fragments[]; };

#endif
