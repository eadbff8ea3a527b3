#include "renderer/photons/surface_samples.h"

#include <array>
#include <atomic>
#include <cassert>
#include <tuple>

#include "renderer/core/parallel_sort.h"
#include "renderer/core/rng.h"
#include "renderer/photons/boundary_tree.h"
#include "renderer/photons/world_triangles.h"

namespace photond {

namespace {

constexpr float kSamplesOfDisc = 128;
// Of a level, before and after thinning. A level with more is left out, and those after it: exact sums there.
constexpr size_t kMostPieces = 1 << 22;

/// A part of a triangle, small against the discs.
struct Piece {
    uint64_t cell;  // in an order that keeps neighbours together
    vec3 centroid;
    uint32_t place;  // within the cell, likewise
    vec3 normal;
    float area_m2;

    bool operator<(const Piece& o) const {
        const auto of = [](const Piece& p) {
            return std::tie(p.cell, p.place, p.centroid.x, p.centroid.y, p.centroid.z, p.area_m2, p.normal.x,
                            p.normal.y, p.normal.z);
        };
        return of(*this) < of(o);
    }
};

/// Bits 0, 3, 6 ... of the result are those of x.
uint64_t spread_bits(uint64_t x) {
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffff;
    x = (x | x << 16) & 0x1f0000ff0000ff;
    x = (x | x << 8) & 0x100f00f00f00f00f;
    x = (x | x << 4) & 0x10c30c30c30c30c3;
    return (x | x << 2) & 0x1249249249249249;
}
/// Morton's order of cells less than 2^20 from the origin.
uint64_t morton(const vec3& cell) {
    const auto number = [](float x) { return spread_bits(static_cast<uint64_t>(static_cast<int64_t>(x) + (1 << 20))); };
    return number(cell.x) | number(cell.y) << 1 | number(cell.z) << 2;
}

/// Chooses pieces in proportion to their area, one of each stratum of so much area as pieces come one after the other:
/// at a random place of it, as pieces may repeat themselves. Those of different directions are kept apart.
class Strata {
public:
    Strata(float area_m2, uint64_t seed) : area_m2_(area_m2), seed_(hash64(seed)) {}

    float area_m2() const { return area_m2_; }
    /// Calls take() once for each stratum that chooses the piece.
    template <class Take>
    void add(const vec3& normal, float area_m2, const Take& take) {
        const vec3 n = glm::abs(normal);
        const size_t axis = n.x > n.y && n.x > n.z ? 0 : n.y > n.z ? 1 : 2;
        const double before = strata_[axis], after = before + double{area_m2} / double{area_m2_};
        strata_[axis] = after;
        for (auto stratum = static_cast<uint64_t>(before); static_cast<double>(stratum) < after; ++stratum) {
            const uint64_t bits = hash64(seed_ + 3 * stratum + axis);
            const double place =
                static_cast<double>(stratum) + double{to_unit_float(static_cast<uint32_t>(bits >> 32))};
            if (before <= place && place < after) take();
        }
    }

private:
    const float area_m2_;
    const uint64_t seed_;
    std::array<double, 3> strata_{};  // passed so far
};

Bounds3 box_of(std::span<const vec3, 3> p) {
    Bounds3 box;
    for (const vec3& corner : p) box.extend(corner);
    return box;
}

/// Cuts triangles into pieces of at most some area, and drops those that lie far from dense cells.
class Cutter {
public:
    Cutter(const DenseCells& cells, size_t level, float area_m2)
        : cells_(cells), level_(level), area_m2_(area_m2), longest_sq_m2_(4 * area_m2) {}

    /// The pieces of a triangle; of those much smaller than wanted the ones that `strata` choose.
    void cut(const TriangleCorners& t, Strata& strata, std::vector<Piece>& out) const {
        const vec3 across = glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
        const float double_m2 = glm::length(across);
        bisect({t.p[0], t.p[1], t.p[2]}, 0.5f * double_m2, across / double_m2, false, strata, out);
    }

private:
    void bisect(const std::array<vec3, 3>& p, float area_m2, const vec3& normal, bool is_near, Strata& strata,
                std::vector<Piece>& out) const {
        size_t longest = 0;
        float longest_sq = 0;
        for (size_t i = 0; i < 3; ++i) {
            const vec3 edge = p[(i + 1) % 3] - p[i];
            if (glm::dot(edge, edge) > longest_sq) longest_sq = glm::dot(edge, edge), longest = i;
        }
        if (area_m2 <= area_m2_ && longest_sq <= longest_sq_m2_) {
            const auto add = [&](float stands_for_m2) {
                const vec3 centroid = (p[0] + p[1] + p[2]) / 3.0f;
                if (is_near || cells_.touches_near(level_, box_of(p)))
                    out.push_back(piece(centroid, normal, stands_for_m2));
            };
            if (area_m2 >= strata.area_m2()) {
                add(area_m2);
            } else {
                strata.add(normal, area_m2, [&] { add(strata.area_m2()); });
            }
            return;
        }
        if (!is_near) {
            const Bounds3 box = box_of(p);
            if (!cells_.touches_near(level_, box)) return;
            is_near = cells_.in_near_cell(level_, box);
        }
        const vec3 a = p[longest], b = p[(longest + 1) % 3], c = p[(longest + 2) % 3], middle = 0.5f * (a + b);
        bisect({a, middle, c}, 0.5f * area_m2, normal, is_near, strata, out);
        bisect({middle, b, c}, 0.5f * area_m2, normal, is_near, strata, out);
    }

    Piece piece(const vec3& centroid, const vec3& normal, float area_m2) const {
        const CubicCells& cells = cells_.cells(level_);
        const vec3 at = (centroid - cells.origin) * cells.per_m, cell = glm::floor(at);
        return {morton(cell), centroid, static_cast<uint32_t>(morton(glm::floor(1023.0f * (at - cell))) & 0x3fffffff),
                normal, area_m2};
    }

    const DenseCells& cells_;
    const size_t level_;
    const float area_m2_, longest_sq_m2_;
};

/// All pieces of the triangles that lie near dense cells; those smaller than `thinned_m2` are thinned at once, so that
/// there are not many more of them than samples. Nothing when they are too many.
std::vector<Piece> cut_all(const WorldTriangles& triangles, const std::vector<uint32_t>& indices, const Cutter& cutter,
                           float thinned_m2) {
    std::atomic<size_t> count = 0;
    std::vector<Piece> pieces =
        gather_blocks<Piece>(indices.size(), [&](size_t begin, size_t end, std::vector<Piece>& out) {
            Strata strata(thinned_m2, begin);
            for (size_t i = begin; i < end && count.load(std::memory_order_relaxed) <= kMostPieces; ++i) {
                const size_t before = out.size();
                cutter.cut(triangles[indices[i]], strata, out);
                count.fetch_add(out.size() - before, std::memory_order_relaxed);
            }
        });
    if (count > kMostPieces) pieces.clear();
    return pieces;
}

/// The triangles, but for needles, and of those with the same corners one.
std::vector<uint32_t> different_triangles(const WorldTriangles& triangles, const DenseCells& cells, float error_m) {
    struct Keyed {
        uint64_t key;
        uint32_t index;
    };
    std::vector<Keyed> keyed =
        gather_blocks<Keyed>(triangles.size(), [&](size_t begin, size_t end, std::vector<Keyed>& out) {
            for (size_t i = begin; i < end; ++i) {
                const TriangleCorners t = triangles[i];
                if (!cells.touches_near(0, box_of(t.p)) || !has_normal(t, error_m)) continue;
                out.push_back(
                    {hash_position(t.p[0]) + hash_position(t.p[1]) + hash_position(t.p[2]), static_cast<uint32_t>(i)});
            }
        });
    parallel_sort(keyed.begin(), keyed.end(),
                  [](const Keyed& a, const Keyed& b) { return a.key != b.key ? a.key < b.key : a.index < b.index; });
    keyed.erase(std::unique(keyed.begin(), keyed.end(), [](const Keyed& a, const Keyed& b) { return a.key == b.key; }),
                keyed.end());
    std::vector<uint32_t> indices(keyed.size());
    std::transform(keyed.begin(), keyed.end(), indices.begin(), [](const Keyed& k) { return k.index; });
    parallel_sort(indices.begin(), indices.end(), std::less<>());  // neighbours side by side
    return indices;
}

/// Each piece that is not much smaller than `area_m2` stands for itself; of smaller ones some are chosen to stand for
/// as much. Fewer where a cell would hold more than `most_of_cell`.
std::vector<Piece> thin(std::vector<Piece>& pieces, float area_m2, size_t most_of_cell) {
    parallel_sort(pieces.begin(), pieces.end(), std::less<>());
    std::vector<Piece> kept;
    for (size_t begin = 0, end; begin < pieces.size(); begin = end) {
        double of_cell_m2 = 0;
        for (end = begin; end < pieces.size() && pieces[end].cell == pieces[begin].cell; ++end)
            of_cell_m2 += double{pieces[end].area_m2};
        // Pieces that stand for themselves are at least half as large: with those, too, no cell holds more.
        const float own_m2 = std::max(area_m2, 2 * static_cast<float>(of_cell_m2 / static_cast<double>(most_of_cell)));
        Strata strata(own_m2, pieces[begin].cell);
        for (size_t i = begin; i < end; ++i) {
            if (pieces[i].area_m2 >= 0.5f * own_m2) {
                kept.push_back(pieces[i]);
            } else {
                strata.add(pieces[i].normal, pieces[i].area_m2,
                           [&] { kept.push_back(pieces[i]), kept.back().area_m2 = own_m2; });
            }
        }
    }
    return kept;
}

}  // namespace

SurfaceSamples::SurfaceSamples(const Scene& scene, std::span<const BoundaryEdge> edges, float radius_m, float error_m,
                               size_t most_edges)
    : cells_(edges, radius_m, most_edges) {
    if (cells_.levels() == 0) return;
    const WorldTriangles triangles(scene);
    std::vector<uint32_t> near = different_triangles(triangles, cells_, error_m);
    size_t all = 0;
    for (size_t level = 0; level < cells_.levels(); ++level) {
        const float area_m2 = kPi * sqr(cells_.radius_m(level)) / kSamplesOfDisc;
        if (sqr(16 * error_m) > area_m2) return;  // rounding would show
        const Cutter cutter(cells_, level, area_m2);
        if (level > 0) {
            near = gather_blocks<uint32_t>(near.size(), [&](size_t begin, size_t end, std::vector<uint32_t>& out) {
                for (size_t i = begin; i < end; ++i)
                    if (cells_.touches_near(level, box_of(triangles[near[i]].p))) out.push_back(near[i]);
            });
        }
        // So much surface that there are too many pieces is crowded in itself, and its cells are thinned anyway.
        constexpr float kMostThinned = 64;
        std::vector<Piece> pieces;
        for (float share = 0.25f; pieces.empty() && share <= kMostThinned; share *= 4)
            pieces = cut_all(triangles, near, cutter, share * area_m2);
        if (pieces.empty()) return;
        const std::vector<Piece> kept = thin(pieces, area_m2, kMostOfCell);
        all += kept.size();
        if (all > kMostPieces) return;

        std::vector<vec3> points(kept.size());
        for (size_t i = 0; i < kept.size(); ++i) points[i] = kept[i].centroid;
        std::vector<uint32_t> order(kept.size());
        Level& made = levels_.emplace_back();
        made.grid = HashGrid(points, cells_.radius_m(level), order);
        made.samples.reserve(kept.size());
        for (const uint32_t i : order) made.samples.push_back({kept[i].normal, kept[i].area_m2});
    }
}

/// The last level whose radius is not less.
size_t SurfaceSamples::level_of(float radius_m) const {
    assert(radius_m > 0 && radius_m <= cells_.radius_m(0));
    size_t level = static_cast<size_t>(std::max(0, std::ilogb(cells_.radius_m(0) / radius_m)));
    if (level > 0 && cells_.radius_m(level) < radius_m) --level;  // the quotient was rounded up
    return level;
}

SurfaceSamples::Mass SurfaceSamples::mass(const Kernel& kernel, const vec3& p, const vec3& normal, float radius_m,
                                          float thickness_m) const {
    struct Layer {
        float mass = 0;
        float mass_height_m = 0;
    };
    std::array<Layer, 2> layers;  // seen from the front, from behind
    const Level& level = levels_[level_of(radius_m)];
    thread_local Neighbours found;
    level.grid.find_within(p, radius_m, found);
    const float inverse_radius_sq = 1 / sqr(radius_m);
    for (const Neighbours::Found& f : found.found) {
        const Sample& sample = level.samples[f.index];
        const float height_m = std::fabs(glm::dot(normal, level.grid.position(f.index) - p));
        const float cosine = glm::dot(normal, sample.normal);
        if (height_m > thickness_m || std::fabs(cosine) < kSameSurface) continue;
        const float q_sq = std::max(0.0f, f.distance_sq_m2 - sqr(height_m)) * inverse_radius_sq;
        const float mass = sample.area_m2 * std::fabs(cosine) * kernel(q_sq) * inverse_radius_sq;
        Layer& layer = layers[cosine < 0];
        layer.mass += mass, layer.mass_height_m += mass * height_m;
    }
    const auto [front, back] = layers;
    const auto samples = static_cast<uint32_t>(found.found.size());
    if (!(front.mass > 0 && back.mass > 0)) return {std::max(front.mass, back.mass), samples};
    const float difference_m = front.mass_height_m / front.mass - back.mass_height_m / back.mass;
    if (std::fabs(difference_m) < 0.25f * thickness_m) return {front.mass + back.mass, samples};
    return {difference_m < 0 ? front.mass : back.mass, samples};
}

size_t SurfaceSamples::size() const {
    size_t size = 0;
    for (const Level& level : levels_) size += level.samples.size();
    return size;
}

uint64_t SurfaceSamples::bytes() const {
    uint64_t bytes = cells_.bytes() + levels_.capacity() * sizeof(Level);
    for (const Level& level : levels_) bytes += level.grid.bytes() + level.samples.capacity() * sizeof(Sample);
    return bytes;
}

}  // namespace photond
