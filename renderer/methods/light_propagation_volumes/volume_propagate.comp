#version 460
// One step of light from cells to their neighbours, a thread a cell that gathers from six. [Kaplanyan and Dachsbacher
// 2010, section 4.3]
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PROPAGATION_CASCADES_BINDING 0
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/light_propagation_volumes/propagation.glsl"

layout(local_size_x = PROPAGATION_GROUP) in;
layout(push_constant, scalar) uniform Push { PropagationPush push; };
layout(set = 0, binding = 1, scalar) readonly buffer OpenFaces { uint open_faces[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Injected { CellLight injected[]; };
layout(set = 0, binding = 3, scalar) readonly buffer StepBefore { CellLight step_before[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer StepAfter { CellLight step_after[]; };
layout(set = 0, binding = 5, scalar) buffer Volume { CellLight volume[]; };

// A cell's far face and one of its sides, as its neighbour's middle sees them [sr]; with four of these, a sixth of all
// directions.
const float kFarFace = 0.40066968;
const float kSideFace = 0.42344136;
// From there to the middle of a side: 2 ahead, 1 aside, over the square root of 5.
const float kAhead = 0.89442719, kAside = 0.44721360;

/// What the coarser cascade has there in all, of which a smaller cell's face gets a quarter.
CellLight light_of_coarser(vec3 position) {
    const uint coarser = push.cascade - 1u;
    const PropagationGrid grid = cascade_grid(coarser);
    const ivec3 cell = ivec3(floor(grid_place(grid, position)));
    CellLight light = NO_LIGHT;
    if (!is_in_grid(grid, cell)) return light;
    const uint index = coarser * cascades.cells + cell_index(grid, cell);
    add_light(light, injected[index], 0.25);
    add_light(light, volume[index], 0.25);
    return light;
}

CellLight light_of_neighbour(PropagationGrid grid, ivec3 cell) {
    if (is_in_grid(grid, cell)) {
        const uint index = cell_index(grid, cell);
        if (push.is_first == 0u) return step_before[index];
        return injected[push.cascade * cascades.cells + index];
    }
    // All that ever comes from outside comes at once.
    if (push.is_first != 0u && push.cascade > 0u) return light_of_coarser(cell_middle(grid, cell));
    return NO_LIGHT;
}

float open_share(PropagationGrid grid, ivec3 cell, int axis) {
    const uint word = open_faces[push.cascade * cascades.faces + face_index(grid, cell)];
    return float(word >> (FACE_BITS * uint(axis)) & FACE_MOST) / float(FACE_MOST);
}

/// `direction`: of the light, along an axis, into the cell. Each face's flux goes on from the cell's middle as a cosine
/// lobe about the face's normal.
void add_flux_of_faces(inout CellLight sum, CellLight light, vec3 direction, int axis, float share) {
    const vec3 uncut = share * uncut_shares(light);
    add_light(sum, cosine_lobe(kFarFace * uncut * intensity(light, direction), direction), 1.0);
    for (int side = 0; side < 4; ++side) {
        vec3 aside = vec3(0.0);
        aside[(axis + 1 + side / 2) % 3] = (side & 1) != 0 ? 1.0 : -1.0;
        const vec3 flux_w = kSideFace * uncut * intensity(light, kAhead * direction + kAside * aside);
        add_light(sum, cosine_lobe(flux_w, aside), 1.0);
    }
}

void main() {
    const uint index = flat_index();
    if (index >= cascades.cells) return;
    const PropagationGrid grid = cascade_grid(push.cascade);
    const ivec3 cell = cell_at(grid, index);
    CellLight sum = NO_LIGHT;
    for (int way = 0; way < 6; ++way) {
        const int axis = way / 2;
        ivec3 towards = ivec3(0);
        towards[axis] = (way & 1) != 0 ? 1 : -1;
        const ivec3 from = cell - towards;
        const float share = open_share(grid, towards[axis] > 0 ? cell : from, axis);
        if (share > 0.0) add_flux_of_faces(sum, light_of_neighbour(grid, from), vec3(towards), axis, share);
    }
    step_after[index] = sum;
    const uint place = push.cascade * cascades.cells + index;
    if (push.is_first == 0u) add_light(sum, volume[place], 1.0);
    volume[place] = sum;
}
