#include "renderer/scene/solid_glass.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <string>

#include "renderer/core/rgb.h"
#include "renderer/scene/pose.h"

namespace photond {

namespace {

/// A directed edge is +1 or -1, by which of its two welded vertices it begins at.
struct Edge {
    uint64_t ends;  // the smaller vertex in the upper half
    int direction;

    uint32_t low() const { return static_cast<uint32_t>(ends >> 32); }
    uint32_t high() const { return static_cast<uint32_t>(ends); }
};

/// For each vertex the first one at the same position.
std::vector<uint32_t> weld_equal(const std::vector<vec3>& positions) {
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

/// The edges between welded vertices that are not run through as often in one direction as in the other, once each.
std::vector<Edge> find_open_edges(const Mesh& mesh, const std::vector<uint32_t>& welded) {
    std::vector<Edge> edges, open;
    edges.reserve(3 * mesh.triangles.size());
    for (const uvec3& triangle : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = welded[triangle[k]], b = welded[triangle[(k + 1) % 3]];
            if (a != b) edges.push_back({uint64_t{std::min(a, b)} << 32 | std::max(a, b), a < b ? 1 : -1});
        }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.ends < b.ends; });
    for (size_t i = 0; i < edges.size();) {
        Edge sum{edges[i].ends, 0};
        for (; i < edges.size() && edges[i].ends == sum.ends; ++i) sum.direction += edges[i].direction;
        if (sum.direction != 0) open.push_back(sum);
    }
    return open;
}

/// Joins what lies in cells side by side: points no farther apart than a cell's side are joined, those more than
/// 2 sqrt(3) sides apart are not but through others. Takes time by the number of points alone, however crowded.
class NearJoins {
public:
    NearJoins(const Mesh& mesh, std::vector<uint32_t> vertices)
        : vertices_(std::move(vertices)), cell_of_(vertices_.size()) {
        Bounds3 bounds;
        for (const uvec3& triangle : mesh.triangles)
            for (int k = 0; k < 3; ++k) bounds.extend(mesh.positions[triangle[k]]);
        // Placed far from the origin, equal points of a mesh may have been rounded apart by a unit in the last place.
        const float farthest = std::max(max_component(glm::abs(bounds.min)), max_component(glm::abs(bounds.max)));
        side_ = std::max({kWeldDistance * bounds.radius(), 2 * std::numeric_limits<float>::epsilon() * farthest,
                          std::numeric_limits<float>::min()});
        for (size_t i = 0; i < vertices_.size(); ++i) {
            const dvec3 place = glm::floor(dvec3(mesh.positions[vertices_[i]] - bounds.min) / double{side_});
            const auto [cell, added] = cells_.try_emplace({int(place.x), int(place.y), int(place.z)}, parent_.size());
            if (added) parent_.push_back(parent_.size());
            cell_of_[i] = cell->second;
        }
        join_neighbours();
    }

    /// Has each of the vertices stand for the first of those that it is joined with. Chains of cells that reach farther
    /// than kReach are left apart: they are the rim of a hole, meshed finely.
    void weld(std::vector<uint32_t>& welded) {
        std::map<size_t, Bounds3> extents;
        for (const auto& [place, cell] : cells_) extents[find(cell)].extend(vec3(place[0], place[1], place[2]));
        std::map<size_t, uint32_t> first;
        std::map<uint32_t, uint32_t> replaced;
        for (size_t i = 0; i < vertices_.size(); ++i) {
            const size_t root = find(cell_of_[i]);
            const Bounds3& extent = extents[root];
            if (max_component(extent.diagonal()) > kReach) continue;
            replaced[vertices_[i]] = first.try_emplace(root, vertices_[i]).first->second;
        }
        for (uint32_t& vertex : welded)
            if (const auto found = replaced.find(vertex); found != replaced.end()) vertex = found->second;
    }

private:
    static constexpr float kReach = 4;  // cells

    size_t find(size_t cell) {
        while (parent_[cell] != cell) cell = parent_[cell] = parent_[parent_[cell]];
        return cell;
    }
    void join_neighbours() {
        for (const auto& [place, cell] : cells_)
            for (int n = 14; n < 27; ++n) {  // half of the neighbours; the others see this one
                const auto other = cells_.find({place[0] + n / 9 - 1, place[1] + n / 3 % 3 - 1, place[2] + n % 3 - 1});
                if (other != cells_.end()) parent_[find(other->second)] = find(cell);
            }
    }

    std::vector<uint32_t> vertices_;
    std::vector<size_t> cell_of_;
    std::map<std::array<int, 3>, size_t> cells_;
    std::vector<size_t> parent_;  // of each cell; roots are their own
    float side_ = 0;
};

/// 0: the surface is closed.
uint64_t count_open_edges(const Mesh& mesh) {
    std::vector<uint32_t> welded = weld_equal(mesh.positions);
    const std::vector<Edge> open = find_open_edges(mesh, welded);
    if (open.empty()) return 0;
    std::vector<uint32_t> ends;
    for (const Edge& edge : open) ends.push_back(edge.low()), ends.push_back(edge.high());
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    NearJoins(mesh, std::move(ends)).weld(welded);
    return find_open_edges(mesh, welded).size();
}

/// What keeps meshes of one material from being filled.
struct Openings {
    uint64_t edges = 0;
    uint32_t meshes = 0;
};

std::string warning_of(const Scene& scene, uint32_t material, const Openings& openings) {
    const std::string& name = scene.materials[material].name;
    return "\"glass\": \"solid\" leaves thin sheets of the material " +
           (name.empty() ? std::to_string(material) : "\"" + name.substr(0, 100) + "\"") +
           ", whose surface is not closed: " + std::to_string(openings.edges) + " open edges in " +
           std::to_string(openings.meshes) + " of its meshes";
}

/// What animations have to do with glass.
struct Motion {
    std::map<uint32_t, const Mesh*>
        stored;                         // by mesh that moves, its shape before it was moved: it may be flat at rest
    std::set<uint32_t> becoming_glass;  // materials whose transmission is animated
};

Motion motion_of(const Scene& scene) {
    Motion motion;
    if (!scene.rig) return motion;
    for (const RiggedMesh& mesh : scene.rig->meshes) motion.stored.emplace(mesh.mesh, &mesh.object->mesh);
    for (const Animation& animation : scene.rig->animations)
        for (const Channel& channel : animation.channels)
            if (channel.property == Property::Transmission)
                for (const uint32_t target : channel.targets)
                    motion.becoming_glass.insert(scene.rig->materials[target].material);
    return motion;
}

/// Has animations of materials drive the twins of these too, and poses the scene's meshes anew as they are at rest.
void drive_twins(Scene& scene, const std::map<uint32_t, uint32_t>& solid_twins) {
    auto rig = std::make_shared<Rig>(*scene.rig);
    std::map<uint32_t, uint32_t> twin_of;  // of the rig's materials
    for (uint32_t k = 0; k < scene.rig->materials.size(); ++k) {
        const auto twin = solid_twins.find(rig->materials[k].material);
        if (twin == solid_twins.end()) continue;
        RiggedMaterial solid = rig->materials[k];
        solid.material = twin->second;
        solid.rest.solid = true;
        twin_of.emplace(k, static_cast<uint32_t>(rig->materials.size()));
        rig->materials.push_back(std::move(solid));
    }
    for (Animation& animation : rig->animations)
        for (Channel& channel : animation.channels)
            for (size_t k = channel.targets.size(); channel.property >= Property::BaseColor && k > 0; --k)
                if (const auto twin = twin_of.find(channel.targets[k - 1]); twin != twin_of.end())
                    channel.targets.push_back(twin->second);
    adopt_rig(scene, std::move(rig));
}

}  // namespace

uint32_t make_closed_glass_solid(Scene& scene) {
    std::map<uint32_t, uint32_t> solid_twins;  // by material; its other meshes may be open
    std::map<uint32_t, Openings> openings;     // likewise
    const Motion motion = motion_of(scene);
    uint32_t changed = 0;
    for (uint32_t m = 0; m < scene.meshes.size(); ++m) {
        Mesh& mesh = scene.meshes[m];
        const auto moving = motion.stored.find(m);
        const Mesh& shape = moving == motion.stored.end() ? mesh : *moving->second;
        const Material& material = scene.materials[mesh.material];
        const bool transmits = material.transmission > 0 || motion.becoming_glass.contains(mesh.material);
        if (!transmits || material.solid || material.unlit || shape.triangles.empty()) continue;
        if (const uint64_t open = count_open_edges(shape); open != 0) {
            Openings& found = openings[mesh.material];
            found.edges += open, ++found.meshes;
            continue;
        }
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
    for (const auto& [material, found] : openings) scene.warnings.push_back(warning_of(scene, material, found));
    if (changed && scene.rig) drive_twins(scene, solid_twins);
    if (changed) scene.needs = find_needs(scene);
    return changed;
}

}  // namespace photond
