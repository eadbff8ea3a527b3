#include "renderer/photons/boundary_edges.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>

#include "renderer/photons/world_triangles.h"
#include "renderer/scene/intersector.h"

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
    vec3 a, b, normal;
    vec3 inward;   // unit, in the triangle's plane, across the edge
    float height;  // of the triangle above the edge [m]

    Side(const TriangleCorners& t, uint32_t corner) : a(t.p[corner]), b(t.p[(corner + 1) % 3]) {
        // In double: the normals of slender triangles would otherwise be off by more than the bends looked for.
        const dvec3 edge = dvec3(b) - dvec3(a), rest = dvec3(t.p[(corner + 2) % 3]) - dvec3(a);
        const dvec3 across = glm::cross(edge, rest), in = glm::cross(across, edge);
        normal = vec3(glm::normalize(across));
        inward = vec3(glm::normalize(in));
        height = static_cast<float>(glm::length(across) / glm::length(edge));
    }
    bool same_edge(const Side& s) const { return (a == s.a && b == s.b) || (a == s.b && b == s.a); }
};

/// Whether the surface's radius of curvature across the edge is less than the disc's radius. A surface that bends less
/// has left the disc's slab where it leaves the cone of 60 degrees: half its radius of curvature below the tangent
/// plane.
bool bends_sharply(const Side& s, const Side& t, float radius_m) {
    constexpr float kLeastBend = 0.02f;  // [rad]; below, sixty degrees take more edges than a disc should hold
    const float bend = std::acos(std::clamp(-glm::dot(s.inward, t.inward), -1.0f, 1.0f));
    return bend > kLeastBend && radius_m * bend > std::min(s.height, t.height);
}

/// The triangles around one edge: pairs of them are surfaces that pass through, the straightest first; others end here.
void resolve_edge(std::vector<Side>& sides, float radius_m, std::vector<BoundaryEdge>& out) {
    constexpr float kSameSide = 0.9998f;   // within about a degree: a coincident triangle, of either winding
    constexpr float kPassThrough = -0.5f;  // bent by less than 60 degrees
    for (size_t i = 0; i < sides.size(); ++i) {
        for (size_t j = sides.size() - 1; j > i; --j) {
            if (glm::dot(sides[i].inward, sides[j].inward) > kSameSide) {
                sides.erase(sides.begin() + static_cast<std::ptrdiff_t>(j));
            }
        }
    }
    while (sides.size() > 1) {
        size_t first = 0, second = 1;
        float least = 2;
        for (size_t i = 0; i < sides.size(); ++i) {
            for (size_t j = i + 1; j < sides.size(); ++j) {
                const float cosine = glm::dot(sides[i].inward, sides[j].inward);
                if (cosine < least) least = cosine, first = i, second = j;
            }
        }
        if (least > kPassThrough) break;
        const Side s = sides[first], t = sides[second];
        if (bends_sharply(s, t, radius_m)) {
            out.push_back({s.a, s.b, s.normal, s.a == t.b ? t.normal : -t.normal, kInfinity});
        }
        sides.erase(sides.begin() + static_cast<std::ptrdiff_t>(second));
        sides.erase(sides.begin() + static_cast<std::ptrdiff_t>(first));
    }
    for (const Side& s : sides) out.push_back({s.a, s.b, s.normal, vec3(0), kInfinity});
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

std::vector<BoundaryEdge> unmatched_edges(const WorldTriangles& triangles, std::vector<HalfEdge> half_edges,
                                          float radius_m) {
    half_edges = sorted(half_edges);
    return gather_blocks<BoundaryEdge>(half_edges.size(), [&](size_t begin, size_t end,
                                                              std::vector<BoundaryEdge>& out) {
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
                resolve_edge(sides, radius_m, out);
            }
        }
    });
}

/// Places just beyond half-edges, at which the scene is asked for another surface: by rays along the normal, to either
/// side, that pass what is no such surface. As many rays as there are layers, however many triangles lie about.
class Probes {
public:
    Probes(const Scene& scene, const Intersector& intersector, float reach_m, float same_plane_m, float error_m)
        : scene_(scene),
          intersector_(intersector),
          reach_m_(reach_m),
          same_plane_m_(same_plane_m),
          step_m_(std::max(1e-5f * reach_m, 2 * error_m)) {}

    void add(const BoundaryEdge& e, uint32_t pieces) {
        const vec3 outward = glm::normalize(glm::cross(e.b - e.a, e.normal));
        for (uint32_t i = 0; i < pieces; ++i) {
            const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(pieces);
            probes_.push_back({glm::mix(e.a, e.b, t) + kBeyond * reach_m_ * outward, e.normal, kInfinity});
        }
    }

    /// Before continues_at_m().
    void trace() {
        parallel_for((probes_.size() + kBatch - 1) / kBatch, 1, [&](size_t batch) {
            const std::span<Probe> probes =
                std::span(probes_).subspan(batch * kBatch, std::min(kBatch, probes_.size() - batch * kBatch));
            look_along(probes, 1);
            look_along(probes, -1);
        });
    }

    float continues_at_m(size_t probe) const {
        const float distance_m = probes_[probe].nearest_m;
        return distance_m > same_plane_m_ ? distance_m : kInfinity;  // in the same plane edges cancel by themselves
    }

private:
    static constexpr float kBeyond = 0.01f;  // of the reach
    static constexpr size_t kBatch = 512;
    static constexpr int kMostRays = 8;  // to one side: beyond so many steep surfaces nothing is looked for
    struct Probe {
        vec3 origin, normal;
        float nearest_m;
    };

    /// Finds the nearest surface on one side, where it is nearer than what is known. Rays start as far behind the probe
    /// as still is the same plane, so that a surface that holds the probe is met.
    void look_along(std::span<Probe> probes, float sign) const {
        std::array<Ray, kBatch> rays;
        std::array<Hit, kBatch> hits;
        std::array<uint32_t, kBatch> of;
        std::array<float, kBatch> passed_m{};
        size_t count = 0;
        for (uint32_t i = 0; i < probes.size(); ++i)
            if (probes[i].nearest_m > same_plane_m_) of[count++] = i;
        for (int step = 0; step < kMostRays && count > 0; ++step) {
            for (size_t k = 0; k < count; ++k) {
                const Probe& probe = probes[of[k]];
                const float from_m = passed_m[of[k]] - same_plane_m_;
                rays[k] = {probe.origin + sign * from_m * probe.normal, sign * probe.normal,
                           std::min(probe.nearest_m, reach_m_) - from_m};
            }
            intersector_.closest_hits({rays.data(), count}, {hits.data(), count}, Coherence::Incoherent);
            size_t left = 0;
            for (size_t k = 0; k < count; ++k) {
                const Hit& hit = hits[k];
                if (!hit.valid()) continue;
                Probe& probe = probes[of[k]];
                if (counts(hit, probe.normal)) {
                    const float distance_m = std::fabs(passed_m[of[k]] - same_plane_m_ + hit.t);
                    probe.nearest_m = std::min(probe.nearest_m, distance_m);
                } else {
                    passed_m[of[k]] += hit.t + step_m_;
                    of[left++] = of[k];
                }
            }
            count = left;
        }
    }

    /// Whether what was hit makes at most 60 degrees with the probe's plane.
    bool counts(const Hit& hit, const vec3& normal) const {
        const TriangleCorners t = world_triangle(scene_, hit.instance, hit.triangle);
        const vec3 across = glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
        return sqr(glm::dot(across, normal)) >= 0.25f * glm::dot(across, across);
    }

    const Scene& scene_;
    const Intersector& intersector_;
    const float reach_m_, same_plane_m_;
    const float step_m_;  // beyond what is passed
    std::vector<Probe> probes_;
};

/// Finds out where surfaces go on below or above half-edges, and cuts half-edges where that changes.
std::vector<BoundaryEdge> probe_beyond(const Scene& scene, const Intersector& intersector,
                                       const std::vector<BoundaryEdge>& edges, float radius_m, float error_m) {
    constexpr float kMostPieces = 64;
    Probes probes(scene, intersector, radius_m, std::max(1e-3f * radius_m, 4 * error_m), error_m);
    std::vector<uint32_t> pieces(edges.size());
    for (size_t i = 0; i < edges.size(); ++i) {
        if (edges[i].other_normal != vec3(0)) continue;
        const float length = glm::length(edges[i].b - edges[i].a);
        pieces[i] = static_cast<uint32_t>(std::clamp(std::ceil(length / radius_m), 1.0f, kMostPieces));
        probes.add(edges[i], pieces[i]);
    }
    probes.trace();

    const auto alike = [](float x, float y) { return x == y || std::fabs(x - y) < 0.1f * std::min(x, y); };
    std::vector<BoundaryEdge> cut;
    cut.reserve(edges.size());
    size_t probe = 0;
    for (size_t i = 0; i < edges.size(); ++i) {
        if (pieces[i] == 0) cut.push_back(edges[i]);
        for (uint32_t from = 0, to; from < pieces[i]; from = to) {
            const float distance = probes.continues_at_m(probe + from);
            for (to = from + 1; to < pieces[i] && alike(distance, probes.continues_at_m(probe + to));) ++to;
            const auto at = [&](uint32_t k) {
                if (k == 0 || k == pieces[i]) return k == 0 ? edges[i].a : edges[i].b;
                return glm::mix(edges[i].a, edges[i].b, static_cast<float>(k) / static_cast<float>(pieces[i]));
            };
            cut.push_back({at(from), at(to), edges[i].normal, vec3(0), distance});
        }
        probe += pieces[i];
    }
    return cut;
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

std::vector<BoundaryEdge> find_boundary_edges(const Scene& scene, const Intersector& intersector, float radius_m) {
    const WorldTriangles triangles(scene);
    const float error_m = position_error_m(scene);
    const uint64_t parts = 3 * triangles.size() / kMostSorted + 1;
    std::vector<BoundaryEdge> edges;
    for (uint64_t part = 0; part < parts; ++part) {
        const std::vector<BoundaryEdge> found =
            unmatched_edges(triangles, collect_half_edges(triangles, error_m, part, parts), radius_m);
        edges.insert(edges.end(), found.begin(), found.end());
    }
    return probe_beyond(scene, intersector, edges, radius_m, error_m);
}

}  // namespace photond
