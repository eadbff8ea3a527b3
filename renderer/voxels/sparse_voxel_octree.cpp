#include "renderer/voxels/sparse_voxel_octree.h"

#include <algorithm>
#include <array>
#include <bit>

#include "renderer/scene/scene.h"

namespace photond {

namespace {

/// The voxel at a node's least corner, as 3 x 10 bits.
uint32_t low_voxel(uint32_t morton, uint32_t level, uint32_t size) {
    uvec3 at(0);
    for (uint32_t bit = 0; bit < level; ++bit)
        for (int axis = 0; axis < 3; ++axis) at[axis] |= (morton >> (3 * bit + static_cast<uint32_t>(axis)) & 1) << bit;
    at *= size;
    return at.x | at.y << 10 | at.z << 20;
}

/// Of bricks' Morton codes in order: the levels' tiles one after the other.
std::vector<gpu::SvoNode> make_nodes(std::vector<uint32_t> codes, uint32_t levels) {
    std::vector<std::vector<uint32_t>> flagged(levels + 1);  // codes by level; 0: the root
    flagged[levels] = std::move(codes);
    for (uint32_t level = levels; level-- > 0;) {
        for (const uint32_t code : flagged[level + 1])
            if (flagged[level].empty() || flagged[level].back() != code >> 3) flagged[level].push_back(code >> 3);
    }
    if (flagged[0].empty()) flagged[0].push_back(0);
    std::vector<gpu::SvoNode> nodes;
    size_t tiles = 0;
    for (uint32_t level = 0; level < levels; ++level) tiles += flagged[level].size();
    nodes.reserve(8 * tiles);
    for (uint32_t level = 1; level <= levels; ++level) {
        const uint32_t size = uint32_t{BRICK_SIDE} << (levels - level), reach = (size - 1) * (1 | 1 << 10 | 1 << 20);
        const size_t next_tile = nodes.size() / 8 + flagged[level - 1].size();
        size_t place = 0;  // among the level's flagged
        for (const uint32_t parent : flagged[level - 1]) {
            for (uint32_t child = 0; child < 8; ++child) {
                const uint32_t code = parent << 3 | child, low = low_voxel(code, level, size);
                gpu::SvoNode node{SVO_LEAF, SVO_NO_DATA, low, low + reach};
                if (place < flagged[level].size() && flagged[level][place] == code) {
                    node.info = level == levels ? SVO_LEAF | SVO_FLAGGED
                                                : SVO_FLAGGED | static_cast<uint32_t>(next_tile + place);
                    if (level == levels) node.data = static_cast<uint32_t>(place);
                    ++place;
                }
                nodes.push_back(node);
            }
        }
    }
    return nodes;
}

}  // namespace

SparseVoxelOctree::SparseVoxelOctree(const Scene& scene, const InstanceBricks& parts)
    : constants_(svo_constants_of(parts.grid())), first_triangles_(first_triangles_of(scene)) {
    constants_.instance_count = static_cast<uint32_t>(scene.instances.size());
    constants_.triangle_count = first_triangles_.back();

    const std::span<const InstanceBrick> bricks = parts.bricks();
    const bool surfaces = parts.has_surfaces();
    std::vector<uint32_t> codes, first_surfaces, numbers;
    codes.reserve(bricks.size()), bricks_.reserve(bricks.size()), first_surfaces.reserve(bricks.size());
    for (size_t i = 0; i < bricks.size();) {
        const uint32_t code = bricks[i].brick;
        std::array<uint32_t, 64> triangles;
        uint64_t mask = 0;
        for (; i < bricks.size() && bricks[i].brick == code; ++i) {
            if (surfaces) {
                const uint32_t first = first_triangles_[bricks[i].instance];
                const uint32_t* triangle = parts.triangles_of(bricks[i]);
                for (uint64_t left = bricks[i].mask; left != 0; left &= left - 1, ++triangle)
                    if (!(mask & left & -left))
                        triangles[static_cast<size_t>(std::countr_zero(left))] = first + *triangle;
            }
            mask |= bricks[i].mask;
        }
        codes.push_back(code);
        bricks_.push_back({{static_cast<uint32_t>(mask), static_cast<uint32_t>(mask >> 32)}});
        first_surfaces.push_back(static_cast<uint32_t>(voxel_count_));
        voxel_count_ += static_cast<uint64_t>(std::popcount(mask));
        for (uint64_t left = mask; surfaces && left != 0; left &= left - 1)
            numbers.push_back(triangles[static_cast<size_t>(std::countr_zero(left))]);
    }
    nodes_ = make_nodes(std::move(codes), constants_.levels);
    cells_.emplace(constants_, nodes_);
    bricks_.shrink_to_fit();
    if (!surfaces) return;
    constants_.surface_base = static_cast<uint32_t>(bricks_.size());
    surfaces_.reserve(first_surfaces.size() + numbers.size());
    surfaces_ = std::move(first_surfaces);
    surfaces_.insert(surfaces_.end(), numbers.begin(), numbers.end());
}

uint64_t SparseVoxelOctree::bytes() const {
    return nodes_.size() * sizeof(gpu::SvoNode) + bricks_.size() * sizeof(gpu::SvoBrick) +
           (surfaces_.size() + first_triangles_.size()) * sizeof(uint32_t) + cells_->bytes();
}

SparseVoxelOctree::Estimate SparseVoxelOctree::estimate(const Scene& scene, const VoxelGrid& grid, bool surfaces) {
    // A convex flat figure thrown at random onto a grid touches 1 + its widths along the axes + the areas of its
    // shadows cells on average, in units of a cell. Neighbours in a mesh share all but the areas.
    const double brick_m = double{grid.cell_m} * BRICK_SIDE;
    double fragments = 0, area = 0;  // shadows', in bricks
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        if (!is_voxelised(scene.materials[mesh.material])) continue;
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const TriangleCorners c = world_triangle(scene, i, t);
            const dvec3 e1 = dvec3(c.p[1] - c.p[0]) / brick_m, e2 = dvec3(c.p[2] - c.p[0]) / brick_m;
            const dvec3 shadow = 0.5 * glm::abs(glm::cross(e1, e2));
            const dvec3 width = glm::max(dvec3(0), glm::max(e1, e2)) - glm::min(dvec3(0), glm::min(e1, e2));
            area += shadow.x + shadow.y + shadow.z;
            fragments += 1 + width.x + width.y + width.z + shadow.x + shadow.y + shadow.z;
        }
    }
    constexpr double kCurved = 1.3;       // edges and curves touch more than planes
    constexpr double kNodesABrick = 3;    // 8 a tile, of which a plane fills 3 or so; levels above, a third more
    constexpr double kVoxelsABrick = 16;  // a plane's
    const double side = static_cast<double>(grid.resolution) / BRICK_SIDE;
    const double bricks = std::min({kCurved * area + 1, fragments + 1, side * side * side});
    const double voxels = kVoxelsABrick * bricks, nodes = kNodesABrick * bricks + 8;
    const double bytes = nodes * sizeof(gpu::SvoNode) + bricks * sizeof(gpu::SvoBrick) +
                         (surfaces ? 4 * (bricks + voxels) : 0) + 4.0 * double(scene.instances.size() + 1) +
                         double(SvoCells::estimate_bytes(grid.resolution));
    const double parts = bricks * sizeof(InstanceBrick) + (surfaces ? 4 * voxels : 0);
    const auto whole = [](double x) { return static_cast<uint64_t>(x); };
    const uint64_t peak = whole(bytes + parts) + InstanceBricks::scratch_bytes(scene.triangle_count, whole(fragments));
    return {whole(fragments), whole(bricks), whole(nodes), whole(voxels), whole(bytes), whole(parts), peak};
}

}  // namespace photond
