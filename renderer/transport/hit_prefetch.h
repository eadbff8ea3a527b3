#pragma once
// A hit's triangle is seldom in the cache, but all hits of a batch are known before the first is shaded: indices are
// asked for as soon as they are, corners and texels some hits ahead of their use.

#include <span>

#include "renderer/scene/intersector.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/surface_color.h"

namespace photond {

inline void prefetch_index(const Scene& scene, const Hit& hit) {
    if (hit.valid()) __builtin_prefetch(&scene.meshes[scene.instances[hit.instance].mesh].triangles[hit.triangle]);
}

inline void prefetch_corners(const Scene& scene, const Hit& hit) {
    const Mesh& mesh = scene.meshes[scene.instances[hit.instance].mesh];
    const uvec3 corner = mesh.triangles[hit.triangle];
    for (int i = 0; i < 3; ++i) {
        __builtin_prefetch(&mesh.positions[corner[i]]);
        if (!mesh.normals.empty()) __builtin_prefetch(&mesh.normals[corner[i]]);
        if (!mesh.uv[0].empty()) __builtin_prefetch(&mesh.uv[0][corner[i]]);
    }
}

/// Asks for the triangle some places after hits[order[position]], so that it is there when it is wanted. All valid.
inline void prefetch_ahead(const Scene& scene, std::span<const Hit> hits, std::span<const uint32_t> order,
                           size_t position) {
    constexpr size_t kCorners = 24, kTexels = 12;  // hits ahead: a texel's place is known by the corners
    const auto corners = [&](size_t k) {
        if (k < order.size()) prefetch_corners(scene, hits[order[k]]);
    };
    const auto texels = [&](size_t k) {
        if (k >= order.size() || !scene.needs.base_color_textures) return;
        const Hit& hit = hits[order[k]];
        prefetch_base_color(scene, scene.meshes[scene.instances[hit.instance].mesh], hit.triangle, hit.u, hit.v);
    };
    if (position == 0) {
        for (size_t k = 0; k < kCorners; ++k) corners(k);
        for (size_t k = 0; k < kTexels; ++k) texels(k);
    }
    corners(position + kCorners);
    texels(position + kTexels);
}

}  // namespace photond
