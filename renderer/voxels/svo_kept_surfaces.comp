#version 460
// Where each brick's triangles begin, and its voxels' triangles as far as they were kept: one thread a brick.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/voxels/svo_build.glsl"

layout(local_size_x = SVO_GROUP) in;
layout(push_constant, scalar) uniform Push { SvoBuildPush push; };

#include "renderer/voxels/svo_first_voxels.glsl"

layout(set = 0, binding = 9, scalar) readonly buffer KeptBricks { uvec2 kept_bricks[]; };
layout(set = 0, binding = 10, scalar) readonly buffer KeptSurfaces { uint kept_surfaces[]; };
layout(set = 0, binding = 11, scalar) readonly buffer KeptPlaces { uint kept_places[]; };

void main() {
    const uint brick = flat_index();
    if (is_short(push) || brick >= brick_count()) return;
    surfaces[brick] = first_voxel(brick);
    uint to = first_surface(brick), from = 0u;
    uvec2 kept = uvec2(0u);
    const uint place = kept_places[brick];
    if (place != SVO_NO_DATA) {
        kept = kept_bricks[place];
        from = push.kept_bricks + kept_surfaces[place];
    }
    for (int word = 0; word < 2; ++word) {
        for (uint left = bricks[brick].mask[word]; left != 0u && to < surfaces.length(); left &= left - 1u, ++to) {
            const bool is_kept = (kept[word] & left & -left) != 0u;
            surfaces[to] = is_kept ? kept_surfaces[from] : SVO_NO_DATA;
            if (is_kept) ++from;
        }
    }
}
