#include "renderer/photons/surface_edges.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>

#include "renderer/photons/world_triangles.h"

namespace photond {

namespace {

constexpr uint64_t kMostSorted = 1 << 23;  // half-edges sorted at once: bounds the scratch, at 16 bytes each

struct HalfEdge {
    uint64_t key;       // of the two ends, in either order
    uint32_t triangle;  // of WorldTriangles
    uint32_t corner;    // it runs from this corner to the next

    bool operator<(const HalfEdge& other) const {
        return key != other.key             ? key < other.key
               : triangle != other.triangle ? triangle < other.triangle
                                            : corner < other.corner;
    }
};

/// The half-edges whose key falls into one of `parts` equal ranges.
std::vector<HalfEdge> collect_half_edges(const WorldTriangles& triangles, float error_m, uint64_t part,
                                         uint64_t parts) {
    const uint64_t range = UINT64_MAX / parts;
    return gather_blocks<HalfEdge>(triangles.size(), [&](size_t begin, size_t end, std::vector<HalfEdge>& out) {
        if (parts == 1) out.reserve(3 * (end - begin));
        for (size_t i = begin; i < end; ++i) {
            const TriangleCorners t = triangles[i];
            const std::array<uint64_t, 3> hash = {hash_position(t.p[0]), hash_position(t.p[1]), hash_position(t.p[2])};
            if (!has_normal(t, error_m)) continue;
            for (uint32_t corner = 0; corner < 3; ++corner) {
                const uint64_t key = hash64(hash[corner] + hash[(corner + 1) % 3]);
                if (std::min(key / range, parts - 1) != part) continue;
                out.push_back({key, static_cast<uint32_t>(i), corner});
            }
        }
    });
}

/// A triangle seen from one of its edges.
struct Side {
    vec3 a, b;
    vec3 inward;   // unit, in the triangle's plane, across the edge
    float height;  // of the triangle above the edge [m]

    Side(const TriangleCorners& t, uint32_t corner) : a(t.p[corner]), b(t.p[(corner + 1) % 3]) {
        // In double: the normals of slender triangles would otherwise be off by more than the bends looked for.
        const dvec3 edge = dvec3(b) - dvec3(a), rest = dvec3(t.p[(corner + 2) % 3]) - dvec3(a);
        const dvec3 across = glm::cross(edge, rest), in = glm::cross(across, edge);
        inward = vec3(glm::normalize(in));
        height = static_cast<float>(glm::length(across) / glm::length(edge));
    }
    bool same_edge(const Side& s) const { return (a == s.a && b == s.b) || (a == s.b && b == s.a); }
};

/// The surface's radius of curvature across the edge; infinite where it hardly bends. A surface that bends less than a
/// disc of that radius has left the disc's slab where it leaves the cone of 60 degrees: half its radius of curvature
/// below the tangent plane.
float radius_of_curvature_m(const Side& s, const Side& t) {
    constexpr float kLeastBend = 0.02f;  // [rad]; below, sixty degrees take more edges than a disc should hold
    const float bend = std::acos(std::clamp(-glm::dot(s.inward, t.inward), -1.0f, 1.0f));
    return bend > kLeastBend ? std::min(s.height, t.height) / bend : kInfinity;
}

/// Of what meets at one edge, once coincident triangles are left out: discs of at most that radius do not mind it. 0
/// where the surface does not go on.
float harmless_radius_m(std::vector<Side>& sides) {
    constexpr float kSameSide = 0.9998f;   // within about a degree: a coincident triangle, of either winding
    constexpr float kPassThrough = -0.5f;  // bent by less than 60 degrees
    for (size_t i = 0; i < sides.size(); ++i)
        for (size_t j = sides.size() - 1; j > i; --j)
            if (glm::dot(sides[i].inward, sides[j].inward) > kSameSide)
                sides.erase(sides.begin() + static_cast<std::ptrdiff_t>(j));
    const bool goes_on = sides.size() == 2 && glm::dot(sides[0].inward, sides[1].inward) <= kPassThrough;
    return goes_on ? radius_of_curvature_m(sides[0], sides[1]) : 0;
}

/// Half-edges of equal keys side by side, in an order that is the same for any number of threads.
std::vector<HalfEdge> sorted(const std::vector<HalfEdge>& half_edges) {
    constexpr size_t kBuckets = 256;
    const auto bucket_of = [](const HalfEdge& e) { return static_cast<size_t>(e.key % kBuckets); };
    std::array<size_t, kBuckets + 1> first{};
    for (const HalfEdge& e : half_edges) ++first[bucket_of(e) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<HalfEdge> by_bucket(half_edges.size());
    std::array<size_t, kBuckets + 1> next = first;
    for (const HalfEdge& e : half_edges) by_bucket[next[bucket_of(e)]++] = e;
    parallel_for(kBuckets, 1, [&](size_t i) {
        const auto at = [&](size_t offset) { return by_bucket.begin() + static_cast<std::ptrdiff_t>(offset); };
        std::sort(at(first[i]), at(first[i + 1]));
    });
    return by_bucket;
}

std::vector<SurfaceEdge> edges_among(const WorldTriangles& triangles, std::vector<HalfEdge> half_edges,
                                     float radius_m) {
    half_edges = sorted(half_edges);
    return gather_blocks<SurfaceEdge>(half_edges.size(), [&](size_t begin, size_t end, std::vector<SurfaceEdge>& out) {
        std::vector<Side> sides, others;
        // A run of equal keys belongs to the block it starts in.
        while (begin > 0 && begin < end && half_edges[begin].key == half_edges[begin - 1].key) ++begin;
        while (begin < end) {
            const uint64_t key = half_edges[begin].key;
            others.clear();
            for (; begin < half_edges.size() && half_edges[begin].key == key; ++begin) {
                others.emplace_back(triangles[half_edges[begin].triangle], half_edges[begin].corner);
            }
            while (!others.empty()) {  // once, unless different edges have the same hash
                sides.clear();
                const Side first = others.front();
                std::erase_if(others, [&](const Side& s) { return s.same_edge(first) && (sides.push_back(s), true); });
                const float harmless_m = harmless_radius_m(sides);
                if (harmless_m < radius_m) out.push_back({first.a, first.b, harmless_m});
            }
        }
    });
}

}  // namespace

float position_error_m(const Scene& scene) {
    Bounds3 bounds;
    for (const Instance& instance : scene.instances) {
        Bounds3 own;
        for (const vec3& p : scene.meshes[instance.mesh].positions) own.extend(p);
        if (own.empty()) continue;
        for (int i = 0; i < 8; ++i) {
            const vec3 corner(i & 1 ? own.max.x : own.min.x, i & 2 ? own.max.y : own.min.y,
                              i & 4 ? own.max.z : own.min.z);
            bounds.extend(instance.identity ? corner : instance.to_world * vec4(corner, 1));
        }
    }
    if (bounds.empty()) return 0;
    const vec3 largest = glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
    return 0x1p-23f * std::max({largest.x, largest.y, largest.z});
}

std::vector<SurfaceEdge> find_surface_edges(const Scene& scene, float radius_m) {
    const WorldTriangles triangles(scene);
    const float error_m = position_error_m(scene);
    const uint64_t parts = 3 * triangles.size() / kMostSorted + 1;
    std::vector<SurfaceEdge> edges;
    for (uint64_t part = 0; part < parts; ++part) {
        const std::vector<SurfaceEdge> found =
            edges_among(triangles, collect_half_edges(triangles, error_m, part, parts), radius_m);
        edges.insert(edges.end(), found.begin(), found.end());
    }
    return edges;
}

}  // namespace photond
