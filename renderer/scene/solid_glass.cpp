#include "renderer/scene/solid_glass.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <numeric>

#include "renderer/scene/scene.h"

namespace photond {

namespace {

/// For each vertex the first one at the same position.
std::vector<uint32_t> weld(const std::vector<vec3>& positions) {
    const auto less = [&](uint32_t a, uint32_t b) {
        const vec3 &p = positions[a], &q = positions[b];
        if (p.x != q.x) return p.x < q.x;
        if (p.y != q.y) return p.y < q.y;
        if (p.z != q.z) return p.z < q.z;
        return a < b;
    };
    std::vector<uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), less);
    std::vector<uint32_t> first(positions.size());
    for (size_t i = 0; i < order.size(); ++i)
        first[order[i]] = i > 0 && positions[order[i]] == positions[order[i - 1]] ? first[order[i - 1]] : order[i];
    return first;
}

bool is_closed(const Mesh& mesh) {
    const std::vector<uint32_t> welded = weld(mesh.positions);
    struct Edge {
        uint64_t ends;  // the smaller vertex in the upper half
        int direction;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (const uvec3& triangle : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = welded[triangle[k]], b = welded[triangle[(k + 1) % 3]];
            if (a != b) edges.push_back({uint64_t{std::min(a, b)} << 32 | std::max(a, b), a < b ? 1 : -1});
        }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.ends < b.ends; });
    for (size_t i = 0; i < edges.size();) {
        int balance = 0;
        const uint64_t ends = edges[i].ends;
        for (; i < edges.size() && edges[i].ends == ends; ++i) balance += edges[i].direction;
        if (balance != 0) return false;
    }
    return !edges.empty();
}

}  // namespace

uint32_t make_closed_glass_solid(Scene& scene) {
    std::map<uint32_t, uint32_t> solid_twins;  // by material; its other meshes may be open
    uint32_t changed = 0;
    for (Mesh& mesh : scene.meshes) {
        const Material& material = scene.materials[mesh.material];
        if (!(material.transmission > 0) || material.solid || material.unlit || !is_closed(mesh)) continue;
        const auto [twin, is_new] =
            solid_twins.try_emplace(mesh.material, static_cast<uint32_t>(scene.materials.size()));
        if (is_new) {
            Material solid = material;
            solid.solid = true;
            scene.materials.push_back(std::move(solid));
        }
        mesh.material = twin->second;
        ++changed;
    }
    if (changed) scene.needs = find_needs(scene);
    return changed;
}

}  // namespace photond
