#version 460
// Rays' answers by a voxel tree.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#define SVO_CONSTANTS_BINDING 1
#define SVO_NODES_BINDING 2
#define SVO_BRICKS_BINDING 3
#define SVO_SURFACES_BINDING 4
#define SVO_FIRST_TRIANGLES_BINDING 5
#include "renderer/voxels/svo_hit.glsl"
#include "tests/gpu/twin.glsl"

struct Answer {
    Hit hit;
    uint occluded;
};
layout(set = 0, binding = 0, scalar) readonly buffer In { Ray rays[]; };
layout(set = 0, binding = 6, scalar) writeonly buffer Out { Answer answers[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    answers[i] = Answer(svo_closest_hit(rays[i]), svo_ray_occluded(rays[i]) ? 1u : 0u);
}
