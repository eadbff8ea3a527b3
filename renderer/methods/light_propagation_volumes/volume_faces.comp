#version 460
// The geometry volume: of a square of points on each face of the cells that the middles of the cell before it or of the
// cell behind it see, how many both see. So cells on two sides of a closed surface are never joined, and what of a face
// lies in a wall beside them says nothing. A thread has a cell's three low faces.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PROPAGATION_CASCADES_BINDING 0
#include "renderer/backends/gpu/bvh.glsl"
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/methods/light_propagation_volumes/propagation.glsl"

layout(local_size_x = PROPAGATION_GROUP) in;
layout(push_constant, scalar) uniform Push { FacesPush push; };
layout(set = 0, binding = 1, scalar) writeonly buffer OpenFaces { uint open_faces[]; };

bool is_seen(vec3 middle, vec3 face_point) {
    const float kPastMiddle = 1e-3;  // what lies in the middle of a cell itself is met from all sides
    const vec3 way = face_point - middle;
    return !occluded(Ray(middle - kPastMiddle * way, way, 1.0 + 2.0 * kPastMiddle));
}

uint open_share(PropagationGrid grid, vec3 middle, int axis) {
    vec3 along = vec3(0.0), across = vec3(0.0), up = vec3(0.0);
    along[axis] = 1.0, across[(axis + 1) % 3] = 1.0, up[(axis + 2) % 3] = 1.0;
    uint by_one = 0u, by_both = 0u;
    for (uint i = 0u; i < FACE_POINTS; ++i) {
        const vec2 at = (vec2(i % FACE_POINTS_SIDE, i / FACE_POINTS_SIDE) + 0.5) / float(FACE_POINTS_SIDE) - 0.5;
        const vec3 face_point = middle + grid.cell_m * (at.x * across + at.y * up - 0.5 * along);
        const bool from_one = is_seen(middle, face_point), from_other = is_seen(middle - grid.cell_m * along, face_point);
        if (from_one || from_other) ++by_one;
        if (from_one && from_other) ++by_both;
    }
    if (by_both == FACE_POINTS) return FACE_OPEN;
    return uint(float(by_both * FACE_MOST) / float(max(by_one, 1u)) + 0.5);
}

void main() {
    const uint thread = push.first + flat_index();
    if (thread >= push.end) return;
    const PropagationGrid grid = cascade_grid(thread / cascades.faces);
    const uint index = thread % cascades.faces;
    const uvec3 rows = grid.cells + 1u;
    const ivec3 cell = ivec3(index % rows.x, index / rows.x % rows.y, index / (rows.x * rows.y));
    uint word = 0u;
    for (int axis = 0; axis < 3; ++axis)
        word |= open_share(grid, cell_middle(grid, cell), axis) << (FACE_BITS * uint(axis));
    open_faces[thread] = word;
}
