#pragma once
// Scenes to voxelise, and voxels as plain sets.

#include <algorithm>
#include <bit>
#include <vector>

#include "renderer/core/rng.h"
#include "renderer/voxels/svo_march.h"
#include "tests/support/scene_parts.h"

namespace photond::test {

inline vec3 random_vec3(RandomStream& random) {
    const vec2 xy = random.next_2d();
    return {xy, random.next()};
}

/// Boxes, slivers of aspect 1e6 and crumbs, a mesh placed several times, one of them mirrored. Not at the origin.
inline Scene voxel_medley() {
    Scene scene;
    RandomStream random(11, RandomDomain::Test, 0, 0);
    MeshBuilder builder;
    builder.box(vec3(-3, -1, -2), vec3(3, 2, 2));
    for (int i = 0; i < 40; ++i) {
        const vec3 at = vec3(6, 3, 4) * random_vec3(random) - vec3(3, 1, 2), along = random_vec3(random) - 0.5f;
        builder.triangle(at, at + 3.0f * along, at + 1.5f * along + 3e-6f * (random_vec3(random) - 0.5f));
        builder.triangle(at, at + 0.01f * along, at + 0.01f * (random_vec3(random) - 0.5f));
    }
    add(scene, builder.build(0), lambert(0.5f));
    add(scene, MeshBuilder().torus(vec3(0), 0.5f, 0.2f, 24, 12).build(0), lambert(0.5f));
    scene.instances.pop_back();
    for (int i = 0; i < 6; ++i) {
        Instance instance;
        instance.mesh = 1;
        instance.identity = false;
        const vec3 at = vec3(4, 2, 3) * random_vec3(random) - vec3(2, 0.5f, 1.5f);
        mat4 place = glm::rotate(glm::translate(mat4(1.0f), at), 6 * random.next(), glm::normalize(vec3(1, 2, 3)));
        place = glm::scale(place, vec3(i == 5 ? -1.0f : 1.0f, 0.3f + random.next(), 1));
        instance.to_world = mat4x3(place);
        instance.normal_to_world = glm::transpose(glm::inverse(mat3(place)));
        instance.flips_orientation = i == 5;
        scene.instances.push_back(instance);
    }
    const vec3 aside(20, -7, 3);
    for (vec3& p : scene.meshes[0].positions) p += aside;
    for (Instance& instance : scene.instances)
        if (!instance.identity) instance.to_world[3] += aside;
    finish_scene(scene);
    return scene;
}

/// x + y n + z n^2 of a tree's set voxels, ascending, found from the root down; with surfaces, their triangles.
struct VoxelList {
    std::vector<uint64_t> voxels;
    std::vector<uint32_t> triangles;

    bool operator==(const VoxelList&) const = default;
};
inline VoxelList list_voxels(const SvoView& tree) {
    struct Place {
        uint32_t tile, level;
    };
    std::vector<Place> stack = {{0, 1}};
    std::vector<std::pair<uint64_t, uint32_t>> found;
    const uint64_t n = tree.constants.grid.resolution;
    while (!stack.empty()) {
        const auto [tile, level] = stack.back();
        stack.pop_back();
        for (uint32_t child = 0; child < 8; ++child) {
            const gpu::SvoNode& node = tree.nodes[size_t{tile} * 8 + child];
            if (!(node.info & SVO_FLAGGED)) continue;
            if (!(node.info & SVO_LEAF)) {
                stack.push_back({node.info & SVO_TILE_MASK, level + 1});
                continue;
            }
            const gpu::SvoBrick& brick = tree.bricks[node.data];
            uint32_t rank = 0;
            for (uint32_t bit = 0; bit < 64; ++bit) {
                if (!(brick.mask[bit / 32] >> bit % 32 & 1)) continue;
                const uint64_t x = (node.low & 1023) + (bit & 3), y = (node.low >> 10 & 1023) + (bit >> 2 & 3),
                               z = (node.low >> 20) + (bit >> 4);
                const uint32_t triangle =
                    tree.surfaces.empty()
                        ? 0
                        : tree.surfaces[size_t{tree.constants.surface_base} + tree.surfaces[node.data] + rank++];
                found.emplace_back(x + n * (y + n * z), triangle);
            }
        }
    }
    std::sort(found.begin(), found.end());
    VoxelList list;
    for (const auto& [voxel, triangle] : found) list.voxels.push_back(voxel), list.triangles.push_back(triangle);
    return list;
}

}  // namespace photond::test
