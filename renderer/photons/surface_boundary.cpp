#include "renderer/photons/surface_boundary.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <span>

#include "renderer/core/parallel.h"
#include "renderer/core/rng.h"
#include "renderer/photons/boundary_edges.h"

namespace photond {

namespace {

constexpr float kSameSurface = 0.5f;  // cosine of the disc test's 60 degrees

/// Cells of space and the edges within the radius of each. A point looks at its own cell only; most find there, in one
/// bit of a small table, that no edge is near.
class CellTable {
public:
    CellTable() = default;
    CellTable(std::span<const BoundaryEdge> edges, float radius_m);

    std::span<const uint32_t> near(const vec3& p) const {
        if (cells_.empty()) return {};
        const vec3 at = glm::floor((p - origin_) * per_cell_);
        const uint64_t hash =
            hash_cell(static_cast<int64_t>(at.x), static_cast<int64_t>(at.y), static_cast<int64_t>(at.z));
        const uint64_t bit = hash >> bit_shift_;
        if ((occupied_[bit / 64] >> (bit % 64) & 1) == 0) return {};
        for (uint64_t slot = hash & slot_mask_; cells_[slot].count > 0; slot = (slot + 1) & slot_mask_) {
            if (cells_[slot].hash == hash) return {edges_.data() + cells_[slot].first, cells_[slot].count};
        }
        return {};
    }
    uint64_t bytes() const {
        return occupied_.size() * sizeof(uint64_t) + cells_.size() * sizeof(Cell) + edges_.size() * sizeof(uint32_t);
    }

private:
    struct Cell {
        uint64_t hash = 0;  // two cells of one hash share their edges, which costs time and changes nothing
        uint64_t first = 0;
        uint32_t count = 0;  // 0: empty slot
    };
    static uint64_t hash_cell(int64_t x, int64_t y, int64_t z) {
        constexpr uint64_t kMask = (1 << 21) - 1;
        return hash64((static_cast<uint64_t>(x) & kMask) | (static_cast<uint64_t>(y) & kMask) << 21 |
                      (static_cast<uint64_t>(z) & kMask) << 42);
    }
    template <class Visit>
    void for_cells_within(const BoundaryEdge& e, float radius_m, const Visit& visit) const;

    vec3 origin_{0};
    float per_cell_ = 0;  // [1/m]
    uint64_t slot_mask_ = 0;
    int bit_shift_ = 0;
    std::vector<uint64_t> occupied_;
    std::vector<Cell> cells_;
    std::vector<uint32_t> edges_;  // by cell
};

/// Walks along the edge's major axis, one layer of cells at a time.
template <class Visit>
void CellTable::for_cells_within(const BoundaryEdge& e, float radius_m, const Visit& visit) const {
    const float reach = 1.0001f * radius_m * per_cell_ + 1e-3f;  // in cells; more than rounding can take away
    const vec3 a = (e.a - origin_) * per_cell_, d = (e.b - origin_) * per_cell_ - a, size = glm::abs(d);
    const int axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
    const auto cell = [](float x) { return static_cast<int64_t>(std::floor(x)); };
    const int64_t last = cell(std::max(a[axis], a[axis] + d[axis]) + reach);
    for (int64_t layer = cell(std::min(a[axis], a[axis] + d[axis]) - reach); layer <= last; ++layer) {
        // The part of the edge that is within reach of the layer.
        float t0 = 0, t1 = 1;
        if (size[axis] > 0) {
            const float from = (static_cast<float>(layer) - reach - a[axis]) / d[axis];
            const float to = (static_cast<float>(layer + 1) + reach - a[axis]) / d[axis];
            t0 = std::clamp(std::min(from, to), 0.0f, 1.0f), t1 = std::clamp(std::max(from, to), 0.0f, 1.0f);
        }
        const vec3 p = a + t0 * d, q = a + t1 * d;
        const vec3 low = glm::min(p, q) - reach, high = glm::max(p, q) + reach;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        std::array<int64_t, 3> at;
        at[static_cast<size_t>(axis)] = layer;
        for (int64_t i = cell(low[u]); i <= cell(high[u]); ++i) {
            for (int64_t j = cell(low[v]); j <= cell(high[v]); ++j) {
                at[static_cast<size_t>(u)] = i, at[static_cast<size_t>(v)] = j;
                visit(hash_cell(at[0], at[1], at[2]));
            }
        }
    }
}

CellTable::CellTable(std::span<const BoundaryEdge> edges, float radius_m) {
    if (edges.empty()) return;
    Bounds3 bounds;
    double length_m = 0;
    for (const BoundaryEdge& e : edges) bounds.extend(e.a), bounds.extend(e.b), length_m += glm::length(e.b - e.a);
    origin_ = bounds.min;
    // Cells of twice the radius: an edge lies in some eight of them. Larger where long edges would take too many.
    const double most_layers = 4 * static_cast<double>(edges.size()) + 65536;
    per_cell_ = 1 / std::max(2 * radius_m, static_cast<float>(length_m / most_layers));

    struct Entry {
        uint64_t hash;
        uint32_t edge;
        bool operator<(const Entry& other) const { return hash != other.hash ? hash < other.hash : edge < other.edge; }
    };
    std::vector<uint64_t> offset(edges.size() + 1, 0);
    parallel_for(edges.size(), 256,
                 [&](size_t i) { for_cells_within(edges[i], radius_m, [&](uint64_t) { ++offset[i + 1]; }); });
    for (size_t i = 0; i < edges.size(); ++i) offset[i + 1] += offset[i];
    std::vector<Entry> entries(offset.back());
    parallel_for(edges.size(), 256, [&](size_t i) {
        uint64_t at = offset[i];
        for_cells_within(edges[i], radius_m, [&](uint64_t hash) { entries[at++] = {hash, static_cast<uint32_t>(i)}; });
    });
    tbb::parallel_sort(entries.begin(), entries.end());

    size_t count = 0;
    for (size_t i = 0; i < entries.size(); ++i) count += i == 0 || entries[i].hash != entries[i - 1].hash;
    const size_t slots = std::bit_ceil(2 * count), bits = std::max<size_t>(64, std::bit_ceil(16 * count));
    slot_mask_ = slots - 1;
    bit_shift_ = 64 - std::countr_zero(bits);
    cells_.resize(slots);
    occupied_.assign(bits / 64, 0);
    edges_.resize(entries.size());
    for (size_t begin = 0, end; begin < entries.size(); begin = end) {
        const uint64_t hash = entries[begin].hash;
        for (end = begin; end < entries.size() && entries[end].hash == hash; ++end) edges_[end] = entries[end].edge;
        uint64_t slot = hash & slot_mask_;
        while (cells_[slot].count > 0) slot = (slot + 1) & slot_mask_;
        cells_[slot] = {hash, begin, static_cast<uint32_t>(end - begin)};
        const uint64_t bit = hash >> bit_shift_;
        occupied_[bit / 64] |= uint64_t{1} << (bit % 64);
    }
}

/// Integral over [s0, s1] of M(q) d / (d^2 + s^2) ds with q^2 = (d^2 + s^2) / r^2, s0 and s1 on the same side of 0.
/// M(q) / q^2 is smooth there, so that four points do (Gauss-Legendre).
float integrate_mass(const Kernel& kernel, float d, float s0, float s1, float radius_m) {
    constexpr std::array<float, 4> kNode = {-0.8611363116f, -0.3399810436f, 0.3399810436f, 0.8611363116f};
    constexpr std::array<float, 4> kWeight = {0.3478548451f, 0.6521451549f, 0.6521451549f, 0.3478548451f};
    const float middle = 0.5f * (s0 + s1), half = 0.5f * (s1 - s0);
    if (half <= 0) return 0;
    float sum = 0;
    for (size_t i = 0; i < kNode.size(); ++i) {
        const float square = sqr(d) + sqr(middle + half * kNode[i]);
        sum += kWeight[i] * kernel.mass_within(std::sqrt(square) / radius_m) / square;
    }
    return half * d * sum;
}

/// The kernel's mass beyond the line at distance d > 0 from the centre, within the angle that s0 ... s1 (along the
/// line, from the foot of the perpendicular, inside the disc) takes up.
float mass_beyond(const Kernel& kernel, float d, float s0, float s1, float radius_m) {
    const float angle = std::atan2(d * (s1 - s0), sqr(d) + s0 * s1);
    const float within = kernel.shape() == KernelShape::Constant ? d * (s1 - s0) / sqr(radius_m)  // M(q) = q^2
                         : s0 < 0 && s1 > 0
                             ? integrate_mass(kernel, d, s0, 0, radius_m) + integrate_mass(kernel, d, 0, s1, radius_m)
                             : integrate_mass(kernel, d, s0, s1, radius_m);
    return (angle - within) * (0.5f * kInvPi);
}

/// Which side of the surfaces an edge bounds for a query, and how.
struct Turn {
    int sign = 0;      // +1: inside is left of a -> b, seen against the normal of the query; 0: no boundary
    size_t layer = 0;  // 0: surfaces seen from the front, 1: from behind
};

Turn turn_of(const BoundaryEdge& e, const vec3& normal) {
    const float c = glm::dot(e.normal, normal), other = glm::dot(e.other_normal, normal);
    const bool front = c >= kSameSurface, other_front = other >= kSameSurface;
    if (front != other_front) return {front ? 1 : -1, 0};
    const bool back = c <= -kSameSurface, other_back = other <= -kSameSurface;
    if (back != other_back) return {back ? -1 : 1, 1};
    return {};
}

}  // namespace

struct SurfaceBoundary::Edges {
    float radius_m;
    float error_m;  // of positions
    std::vector<BoundaryEdge> edges;
    CellTable cells;

    Edges(const Scene& scene, float radius)
        : radius_m(radius),
          error_m(position_error_m(scene)),
          edges(find_boundary_edges(scene, radius)),
          cells(edges, radius) {}
};

SurfaceBoundary::SurfaceBoundary(const Scene& scene, float radius_m)
    : edges_(std::make_unique<const Edges>(scene, radius_m)) {}
SurfaceBoundary::~SurfaceBoundary() = default;
SurfaceBoundary::SurfaceBoundary(SurfaceBoundary&&) noexcept = default;

float SurfaceBoundary::mass_on_surface(const Kernel& kernel, const vec3& p, const vec3& normal, float radius_m,
                                       float thickness_m) const {
    assert(radius_m <= edges_->radius_m && "edges farther off are not in the cell of p");
    const std::span<const uint32_t> near = edges_->cells.near(p);
    if (near.empty()) return 1;

    const float on_line_m = 1e-5f * radius_m + 2 * edges_->error_m;
    struct Layer {
        float lost = 0;
        float height_m = kInfinity;  // least distance of an edge from the tangent plane
    };
    std::array<Layer, 2> layers;
    for (const uint32_t index : near) {
        const BoundaryEdge& e = edges_->edges[index];
        const Turn turn = turn_of(e, normal);
        if (turn.sign == 0) continue;

        // The edge in the tangent plane: line at signed distance d, of which s0 ... s1 is the edge.
        const vec3 a = e.a - p, ab = e.b - e.a;
        const float height_a = glm::dot(a, normal), rise = glm::dot(ab, normal);
        const float length_sq = glm::dot(ab, ab) - sqr(rise);
        const float area = glm::dot(normal, glm::cross(a, ab));
        if (!(sqr(area) < sqr(radius_m) * length_sq)) continue;
        const float length = std::sqrt(length_sq), d = area / length;
        if (std::fabs(d) <= on_line_m) continue;  // which side p is on cannot be told
        const float start = (glm::dot(a, ab) - height_a * rise) / length;
        const float half_chord = std::sqrt(sqr(radius_m) - sqr(d));
        float s0 = std::max(start, -half_chord), s1 = std::min(start + length, half_chord);

        // The part of it within the thickness of the disc.
        const float slope = rise / length;
        if (std::fabs(height_a) > thickness_m || std::fabs(height_a + rise) > thickness_m) {
            if (slope == 0) continue;
            const float t0 = start + (-thickness_m - height_a) / slope, t1 = start + (thickness_m - height_a) / slope;
            s0 = std::max(s0, std::min(t0, t1)), s1 = std::min(s1, std::max(t0, t1));
        }
        if (!(s0 < s1)) continue;

        Layer& layer = layers[turn.layer];
        layer.height_m = std::min(layer.height_m, std::fabs(height_a + slope * (std::clamp(0.0f, s0, s1) - start)));
        if (e.continues_at_m <= thickness_m) continue;
        const float beyond = mass_beyond(kernel, std::fabs(d), s0, s1, radius_m);
        layer.lost += (d > 0) == (turn.sign > 0) ? beyond : -beyond;
    }
    // p lies on the layer whose edges are nearer to its plane; one sheet with both windings has both at equal height.
    const float difference_m = layers[0].height_m - layers[1].height_m;
    const float same_m = 1e-3f * radius_m + edges_->error_m;
    const float lost = std::fabs(difference_m) <= same_m ? std::max(layers[0].lost, layers[1].lost)
                       : difference_m < 0                ? layers[0].lost
                                                         : layers[1].lost;
    return std::clamp(1 - lost, kLeastMass, 1.0f);
}

size_t SurfaceBoundary::edges() const { return edges_->edges.size(); }

uint64_t SurfaceBoundary::bytes() const {
    return sizeof(Edges) + edges_->edges.size() * sizeof(BoundaryEdge) + edges_->cells.bytes();
}

}  // namespace photond
