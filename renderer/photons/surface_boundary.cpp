#include "renderer/photons/surface_boundary.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "renderer/photons/boundary_tree.h"
#include "renderer/photons/surface_samples.h"

namespace photond {

namespace {

/// Integral over [s0, s1] of M(q) d / (d^2 + s^2) ds with q^2 = (d^2 + s^2) / r^2. M(q) / q^2 is smooth on either side
/// of s = 0, so that four points do for each (Gauss-Legendre).
float integrate_mass(const Kernel& kernel, float d, float s0, float s1, float radius_m) {
    constexpr std::array<float, 4> kNode = {-0.8611363116f, -0.3399810436f, 0.3399810436f, 0.8611363116f};
    constexpr std::array<float, 4> kWeight = {0.3478548451f, 0.6521451549f, 0.6521451549f, 0.3478548451f};
    if (s0 < 0 && s1 > 0)
        return integrate_mass(kernel, d, s0, 0, radius_m) + integrate_mass(kernel, d, 0, s1, radius_m);
    const float middle = 0.5f * (s0 + s1), half = 0.5f * (s1 - s0);
    float sum = 0;
    for (size_t i = 0; i < kNode.size(); ++i) {
        const float square = sqr(d) + sqr(middle + half * kNode[i]);
        sum += kWeight[i] * kernel.mass_within(std::sqrt(square) / radius_m) / square;
    }
    return half * d * sum;
}

/// The same for several edges; 0 where not `active`.
FloatLanes integrate_mass(const Kernel& kernel, const FloatLanes& d, const FloatLanes& s0, const FloatLanes& s1,
                          float radius_m, const FloatMask& active) {
    const float inverse_sq = 1 / sqr(radius_m);
    switch (kernel.shape()) {
        case KernelShape::Constant: return inverse_sq * d * (s1 - s0);  // M(q) = q^2
        case KernelShape::Epanechnikov:                                 // q^2 (2 - q^2)
            return inverse_sq * d * (s1 - s0) *
                   (2.0f - inverse_sq * (d * d + (s0 * s0 + s0 * s1 + s1 * s1) * (1.0f / 3.0f)));
        case KernelShape::Cone:
        case KernelShape::Gaussian: break;
    }
    FloatLanes sum = 0;
    for (size_t i = 0; i < kLanes; ++i)
        if (active[i]) sum[i] = integrate_mass(kernel, d[i], s0[i], s1[i], radius_m);
    return sum;
}

/// atan2(y, x) for y >= 0, not both 0; to 3e-7. [Moshier 1989] Methods and Programs for Mathematical Functions
/// (Cephes).
FloatLanes angle_of(const FloatLanes& y, const FloatLanes& x) {
    constexpr float kTanEighth = 0.41421356f;  // tan(pi / 8)
    const FloatLanes ax = abs(x), low = min(ax, y), high = max(ax, y);
    const FloatMask wide = low > kTanEighth * high;
    const FloatLanes t = select(wide, low - high, low) / select(wide, low + high, high), t2 = t * t;
    const FloatLanes series =
        (((8.05374449538e-2f * t2 - 1.38776856032e-1f) * t2 + 1.99777106478e-1f) * t2 - 3.33329491539e-1f) * t2 * t + t;
    const FloatLanes first = select(wide, series + 0.25f * kPi, series);   // of low / high
    const FloatLanes quarter = select(y > ax, 0.5f * kPi - first, first);  // of y / |x|
    return select(x < 0, kPi - quarter, quarter);
}

/// Where mass is asked for.
struct Disc {
    vec3 centre, normal;
    float radius_m;
    float thickness_m;
    float on_line_m;  // lines nearer than this run through the centre, to rounding
};

/// What edges cut off of the surfaces seen from the front, and of those seen from behind. Of the edges that pass by the
/// cones of normals few bound a surface: those are collected, so that the rest is worked out for kLanes of them at
/// once.
class LostMass {
public:
    struct Layer {
        float lost;
        float height_m;  // least distance of an edge from the tangent plane
    };

    LostMass(const Kernel& kernel, const Disc& disc) : kernel_(kernel), disc_(disc) {}

    void add(const EdgeBlock& e) {
        const Turns turns(e.normal.load(), e.other_normal.load(), broadcast(disc_.normal));
        const FloatMask bounds = turns.of_front || turns.of_back;
        for (uint32_t lane = 0; lane < kLanes; ++lane) {  // which ones cannot be foretold: no branches
            waiting_[count_] = {&e, lane};
            count_ += bounds[lane];
        }
        if (count_ >= kLanes) {
            add_waiting(kLanes);
            count_ -= kLanes;
            std::copy_n(waiting_.begin() + kLanes, kLanes, waiting_.begin());
        }
    }

    std::array<Layer, 2> finish() {
        if (count_ > 0) add_waiting(count_);
        return {layer(0), layer(1)};
    }

private:
    Layer layer(size_t i) const { return {0.5f * kInvPi * reduce(lost_[i]), hmin(height_m_[i])}; }

    /// Which side of the surfaces edges bound, if any.
    struct Turns {
        FloatMask of_front, of_back;
        FloatMask inside_left;  // of a -> b, seen against the normal of the query

        Turns(const Vec3Lanes& normal, const Vec3Lanes& other_normal, const Vec3Lanes& n) {
            const FloatLanes c = dot(normal, n), other = dot(other_normal, n);
            const FloatMask front = c >= kSameSurface, back = c <= -kSameSurface;
            of_front = front != (other >= kSameSurface);
            of_back = !of_front && back != (other <= -kSameSurface);
            inside_left = (of_front && front) || (of_back && !back);
        }
    };
    struct Waiting {
        const EdgeBlock* block;
        uint32_t lane;
    };

    /// The first `count` of the edges that wait, at most kLanes.
    void add_waiting(size_t count) {
        EdgeBlock e;
        for (size_t i = 0; i < count; ++i) {
            const EdgeBlock& from = *waiting_[i].block;
            const size_t lane = waiting_[i].lane;
            for (size_t axis = 0; axis < 3; ++axis) {
                e.a.axis[axis][i] = from.a.axis[axis][lane];
                e.ab.axis[axis][i] = from.ab.axis[axis][lane];
                e.normal.axis[axis][i] = from.normal.axis[axis][lane];
                e.other_normal.axis[axis][i] = from.other_normal.axis[axis][lane];
            }
            e.continues_at_m[i] = from.continues_at_m[lane];
        }
        add_all(e);
    }

    void add_all(const EdgeBlock& e) {
        const float radius_m = disc_.radius_m, thickness_m = disc_.thickness_m;
        const Vec3Lanes n = broadcast(disc_.normal), a = e.a.load() - broadcast(disc_.centre), ab = e.ab.load();
        const Turns turns(e.normal.load(), e.other_normal.load(), n);
        FloatMask bounds = turns.of_front || turns.of_back;

        // The edges in the tangent plane: lines at signed distance d, of which s0 ... s1 are the edges.
        const FloatLanes height_a = dot(a, n), rise = dot(ab, n);
        const FloatLanes length_sq = dot(ab, ab) - rise * rise, area = dot(n, cross(a, ab));
        bounds = bounds && area * area < sqr(radius_m) * length_sq;
        const FloatLanes per_length = 1.0f / sqrt(length_sq), d = area * per_length, distance = abs(d);
        bounds = bounds && distance > disc_.on_line_m;  // nearer: which side the centre is on cannot be told
        const FloatLanes start = (dot(a, ab) - height_a * rise) * per_length;
        const FloatLanes half_chord = sqrt(max(sqr(radius_m) - d * d, FloatLanes(0)));
        FloatLanes s0 = max(start, -half_chord), s1 = min(start + length_sq * per_length, half_chord);

        // The part of them within the thickness of the disc.
        const FloatLanes slope = rise * per_length;
        const FloatMask sticks_out = abs(height_a) > thickness_m || abs(height_a + rise) > thickness_m;
        if (any_of(sticks_out && bounds)) {
            const FloatLanes t0 = start + (-thickness_m - height_a) / slope,
                             t1 = start + (thickness_m - height_a) / slope;
            s0 = select(sticks_out, max(s0, min(t0, t1)), s0), s1 = select(sticks_out, min(s1, max(t0, t1)), s1);
            bounds = bounds && !(sticks_out && slope == 0);
        }
        bounds = bounds && s0 < s1;
        if (none_of(bounds)) return;
        const FloatLanes height = abs(height_a + slope * (min(max(FloatLanes(0), s0), s1) - start));

        // The kernel's mass beyond the lines, within the angles that s0 ... s1 take up.
        const FloatLanes continues_at_m(e.continues_at_m.data(), std::experimental::vector_aligned);
        const FloatMask counts = bounds && continues_at_m > thickness_m;
        const FloatLanes beyond = angle_of(distance * (s1 - s0), d * d + s0 * s1) -
                                  integrate_mass(kernel_, distance, s0, s1, radius_m, counts);
        const FloatLanes lost = select(counts, select((d > 0) == turns.inside_left, beyond, -beyond), 0);
        for (size_t i = 0; i < 2; ++i) {
            const FloatMask own = bounds && (i == 0 ? turns.of_front : turns.of_back);
            height_m_[i] = select(own, min(height_m_[i], height), height_m_[i]);
            lost_[i] = select(own, lost_[i] + lost, lost_[i]);
        }
    }

    const Kernel& kernel_;
    const Disc& disc_;
    std::array<Waiting, 2 * kLanes> waiting_;
    size_t count_ = 0;
    // Of the front, of the back:
    std::array<FloatLanes, 2> lost_ = {FloatLanes(0), FloatLanes(0)};
    std::array<FloatLanes, 2> height_m_ = {FloatLanes(kInfinity), FloatLanes(kInfinity)};
};

}  // namespace

struct SurfaceBoundary::Edges {
    float radius_m;
    float error_m;  // of positions
    SurfaceSamples samples;
    BoundaryTree tree;

    Edges(const Scene& scene, float radius, float error, std::vector<BoundaryEdge> edges)
        : radius_m(radius),
          error_m(error),
          samples(scene, edges, radius, error, kDenseEdges),
          tree(std::move(edges), radius) {}
};

SurfaceBoundary::SurfaceBoundary(const Scene& scene, const Intersector& intersector, float radius_m)
    : edges_(std::make_unique<const Edges>(scene, radius_m, position_error_m(scene),
                                           find_boundary_edges(scene, intersector, radius_m))) {}
SurfaceBoundary::~SurfaceBoundary() = default;
SurfaceBoundary::SurfaceBoundary(SurfaceBoundary&&) noexcept = default;

float SurfaceBoundary::mass_on_surface(const Kernel& kernel, const vec3& p, const vec3& normal, float radius_m,
                                       float thickness_m) const {
    assert(radius_m <= edges_->radius_m && "edges farther off are not known to the cell of p");
    if (!edges_->tree.may_have_edges(p)) return 1;

    const Disc disc{p, normal, radius_m, thickness_m, 1e-5f * radius_m + 2 * edges_->error_m};
    LostMass lost_mass(kernel, disc);
    const SurfaceSamples& samples = edges_->samples;
    const auto limit = samples.cover(p, radius_m) ? BoundaryTree::Limit::Limited : BoundaryTree::Limit::None;
    if (!edges_->tree.visit_blocks(p, normal, radius_m, thickness_m, limit,
                                   [&](const EdgeBlock& e) { lost_mass.add(e); }))
        return std::clamp(samples.mass(kernel, p, normal, radius_m, thickness_m).mass, kLeastMass, 1.0f);
    const auto [front, back] = lost_mass.finish();
    // p lies on the layer whose edges are nearer to its plane; one sheet with both windings has both at equal height.
    const float difference_m = front.height_m - back.height_m;
    const float same_m = 1e-3f * radius_m + edges_->error_m;
    const float lost = std::fabs(difference_m) <= same_m ? std::max(front.lost, back.lost)
                       : difference_m < 0                ? front.lost
                                                         : back.lost;
    return std::clamp(1 - lost, kLeastMass, 1.0f);
}

size_t SurfaceBoundary::edges() const { return edges_->tree.size(); }

size_t SurfaceBoundary::samples() const { return edges_->samples.size(); }

uint64_t SurfaceBoundary::bytes() const { return sizeof(Edges) + edges_->tree.bytes() + edges_->samples.bytes(); }

}  // namespace photond
