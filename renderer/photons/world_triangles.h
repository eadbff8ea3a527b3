#pragma once
// The triangles of a whole scene in world space, as the boundary of its surfaces is worked out from them.

#include <algorithm>
#include <bit>
#include <vector>

#include "renderer/core/parallel.h"
#include "renderer/core/rng.h"
#include "renderer/scene/scene.h"

namespace photond {

/// All triangles of all instances, numbered through, front side by the winding in world space. The scene is borrowed.
class WorldTriangles {
public:
    explicit WorldTriangles(const Scene& scene) : scene_(scene) {
        for (const Instance& instance : scene.instances) {
            first_.push_back(count_);
            count_ += scene.meshes[instance.mesh].triangles.size();
        }
    }
    uint64_t size() const { return count_; }
    TriangleCorners operator[](uint64_t index) const {
        const auto after = std::upper_bound(first_.begin(), first_.end(), index);
        const auto instance = static_cast<uint32_t>(after - first_.begin() - 1);
        TriangleCorners corners = world_triangle(scene_, instance, static_cast<uint32_t>(index - first_[instance]));
        if (scene_.instances[instance].flips_orientation) std::swap(corners.p[1], corners.p[2]);
        return corners;
    }

private:
    const Scene& scene_;
    std::vector<uint64_t> first_;
    uint64_t count_ = 0;
};

/// The same for corners at equal places, whatever mesh they belong to.
inline uint64_t hash_position(const vec3& p) {
    const vec3 q = p + vec3(0);  // -0 and 0 are the same place
    const auto bits = [](float x) { return uint64_t{std::bit_cast<uint32_t>(x)}; };
    return hash64(hash64(bits(q.x) | bits(q.y) << 32) + bits(q.z));
}

/// Needles thinner than the rounding of their corners have no normal; left out, they leave no gap either.
inline bool has_normal(const TriangleCorners& t, float error_m) {
    const vec3 e0 = t.p[1] - t.p[0], e1 = t.p[2] - t.p[1], e2 = t.p[0] - t.p[2];
    const vec3 across = glm::cross(e0, e1);
    const float longest_sq = std::max({glm::dot(e0, e0), glm::dot(e1, e1), glm::dot(e2, e2)});
    return glm::dot(across, across) > sqr(error_m) * longest_sq;  // area / longest = least height
}

/// Appends what `make(begin, end, out)` appends for each block of [0, count), in the order of the blocks: the same for
/// any number of threads.
template <class T, class Make>
std::vector<T> gather_blocks(size_t count, const Make& make) {
    constexpr size_t kBlock = 4096;  // a thread takes at once
    std::vector<std::vector<T>> blocks((count + kBlock - 1) / kBlock);
    parallel_for(blocks.size(), 1, [&](size_t i) { make(i * kBlock, std::min(count, (i + 1) * kBlock), blocks[i]); });
    std::vector<size_t> offset(blocks.size() + 1, 0);
    for (size_t i = 0; i < blocks.size(); ++i) offset[i + 1] = offset[i] + blocks[i].size();
    std::vector<T> all(offset.back());
    parallel_for(blocks.size(), 1, [&](size_t i) {
        std::copy(blocks[i].begin(), blocks[i].end(), all.begin() + static_cast<std::ptrdiff_t>(offset[i]));
    });
    return all;
}

}  // namespace photond
