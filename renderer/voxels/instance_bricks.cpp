#include "renderer/voxels/instance_bricks.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "renderer/core/morton.h"
#include "renderer/core/parallel.h"
#include "renderer/core/parallel_sort.h"
#include "renderer/scene/scene.h"
#include "renderer/voxels/triangle_voxels.h"

namespace photond {

namespace {

constexpr uint64_t kColumnsATask = 4096;

/// Some instances' triangles, numbered one instance after the other.
struct AskedTriangles {
    const gpu::SvoConstants& constants;
    const Scene& scene;
    std::span<const uint32_t> instances;
    std::span<const uint32_t> first;  // of each, and the number of all

    TriangleVoxels voxels(size_t place, uint32_t triangle) const {
        return {quantised_triangle(constants, scene, instances[place], triangle),
                static_cast<int32_t>(constants.grid.resolution / BRICK_SIDE)};
    }
    TriangleVoxels voxels(uint32_t number) const {
        const auto place =
            static_cast<size_t>(std::upper_bound(first.begin(), first.end(), number) - first.begin()) - 1;
        return voxels(place, number - first[place]);
    }
};

/// Where each triangle's columns of bricks begin; the last number is that of all.
std::vector<uint64_t> count_columns(const AskedTriangles& asked) {
    std::vector<uint64_t> begin(size_t{asked.first.back()} + 1);
    parallel_for(asked.instances.size(), 1, [&](size_t place) {
        const Mesh& mesh = asked.scene.meshes[asked.scene.instances[asked.instances[place]].mesh];
        if (!is_voxelised(asked.scene.materials[mesh.material])) return;
        parallel_for(mesh.triangles.size(), 1024, [&](size_t triangle) {
            begin[asked.first[place] + triangle + 1] = asked.voxels(place, static_cast<uint32_t>(triangle)).columns();
        });
    });
    for (size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
    return begin;
}

}  // namespace

/// A triangle's voxels in one brick.
struct InstanceBricks::Fragment {
    uint32_t brick;
    uint32_t triangle;
    uint64_t mask;
};

/// In the order of (brick, triangle).
std::vector<InstanceBricks::Fragment> InstanceBricks::make_fragments(const Scene& scene,
                                                                     std::span<const uint32_t> instances,
                                                                     std::span<const uint32_t> first) const {
    const AskedTriangles asked{constants_, scene, instances, first};
    const std::vector<uint64_t> begin = count_columns(asked);
    std::vector<std::vector<Fragment>> parts((begin.back() + kColumnsATask - 1) / kColumnsATask);
    parallel_for(parts.size(), 1, [&](size_t part) {
        uint64_t column = part * kColumnsATask;
        const uint64_t end = std::min(column + kColumnsATask, begin.back());
        auto number = static_cast<uint32_t>(std::upper_bound(begin.begin(), begin.end(), column) - begin.begin() - 1);
        for (; column < end; ++number) {
            if (begin[number + 1] <= column) continue;
            const TriangleVoxels triangle = asked.voxels(number);
            for (; column < std::min(end, begin[number + 1]); ++column) {
                glm::ivec3 brick;
                const BrickRange range = triangle.column(static_cast<uint32_t>(column - begin[number]), brick);
                for (int32_t along = range.begin; along < range.end; ++along) {
                    brick[triangle.axis()] = along;
                    if (const uint64_t mask = triangle.brick_mask(brick))
                        parts[part].push_back({morton_code(uvec3(brick)), number, mask});
                }
            }
        }
    });
    size_t count = 0;
    for (const auto& part : parts) count += part.size();
    std::vector<Fragment> fragments;
    fragments.reserve(count);
    for (std::vector<Fragment>& part : parts) {
        fragments.insert(fragments.end(), part.begin(), part.end());
        part = {};
    }
    parallel_sort(fragments.begin(), fragments.end(), [](const Fragment& a, const Fragment& b) {
        return a.brick != b.brick ? a.brick < b.brick : a.triangle < b.triangle;
    });
    return fragments;
}

InstanceBricks::InstanceBricks(const Scene& scene, const VoxelGrid& grid, bool surfaces)
    : constants_(svo_constants_of(grid)), surfaces_(surfaces) {
    std::vector<uint32_t> all(scene.instances.size());
    std::iota(all.begin(), all.end(), 0u);
    update(scene, all);
}

void InstanceBricks::update(const Scene& scene, std::span<const uint32_t> instances) {
    std::vector<uint32_t> first = {0};
    for (const uint32_t instance : instances) {
        const Mesh& mesh = scene.meshes[scene.instances[instance].mesh];
        first.push_back(first.back() + static_cast<uint32_t>(mesh.triangles.size()));
    }
    const std::vector<Fragment> fragments = make_fragments(scene, instances, first);
    std::vector<bool> replaced(scene.instances.size());
    for (const uint32_t instance : instances) replaced[instance] = true;

    const std::vector<InstanceBrick> before = std::exchange(bricks_, {});
    const std::vector<uint32_t> triangles_before = std::exchange(triangles_, {});
    bricks_.reserve(before.size());
    triangles_.reserve(triangles_before.size());
    auto kept = before.begin();
    const auto keep_until = [&](uint32_t brick, uint32_t instance) {
        for (; kept != before.end(); ++kept) {
            if (kept->brick > brick || (kept->brick == brick && kept->instance > instance)) return;
            if (replaced[kept->instance]) continue;
            const auto from = triangles_before.begin() + static_cast<std::ptrdiff_t>(kept->first_triangle);
            bricks_.push_back({kept->brick, kept->instance, kept->mask, triangles_.size()});
            if (surfaces_) triangles_.insert(triangles_.end(), from, from + std::popcount(kept->mask));
        }
    };
    for (size_t i = 0; i < fragments.size();) {
        const uint32_t brick = fragments[i].brick;
        const auto place = static_cast<size_t>(std::upper_bound(first.begin(), first.end(), fragments[i].triangle) -
                                               first.begin() - 1);
        std::array<uint32_t, 64> least;
        uint64_t mask = 0;
        for (; i < fragments.size() && fragments[i].brick == brick && fragments[i].triangle < first[place + 1]; ++i) {
            for (uint64_t fresh = fragments[i].mask & ~mask; surfaces_ && fresh != 0; fresh &= fresh - 1)
                least[static_cast<size_t>(std::countr_zero(fresh))] = fragments[i].triangle - first[place];
            mask |= fragments[i].mask;
        }
        keep_until(brick, instances[place]);
        bricks_.push_back({brick, instances[place], mask, triangles_.size()});
        for (uint64_t left = mask; surfaces_ && left != 0; left &= left - 1)
            triangles_.push_back(least[static_cast<size_t>(std::countr_zero(left))]);
    }
    keep_until(UINT32_MAX, UINT32_MAX);
    bricks_.shrink_to_fit();
    triangles_.shrink_to_fit();
}

uint64_t InstanceBricks::bytes() const {
    return bricks_.capacity() * sizeof(InstanceBrick) + triangles_.capacity() * sizeof(uint32_t);
}

uint64_t InstanceBricks::scratch_bytes(uint64_t triangles, uint64_t fragments) {
    return 2 * fragments * sizeof(Fragment) + triangles * sizeof(uint64_t);
}

}  // namespace photond
