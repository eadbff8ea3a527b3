#include "renderer/photons/surface_boundary.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "renderer/photons/boundary_tree.h"

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

/// The surfaces seen from the front, or those seen from behind: what the edges cut off of them.
struct Layer {
    FloatLanes lost = 0;
    FloatLanes height_m = kInfinity;  // least distance of an edge from the tangent plane

    void add(const FloatMask& bounds, const FloatLanes& edge_height_m, const FloatLanes& edge_lost) {
        height_m = select(bounds, min(height_m, edge_height_m), height_m);
        lost = select(bounds, lost + edge_lost, lost);
    }
};

}  // namespace

struct SurfaceBoundary::Edges {
    float radius_m;
    float error_m;  // of positions
    BoundaryTree tree;

    Edges(const Scene& scene, float radius)
        : radius_m(radius), error_m(position_error_m(scene)), tree(find_boundary_edges(scene, radius), radius) {}
};

SurfaceBoundary::SurfaceBoundary(const Scene& scene, float radius_m)
    : edges_(std::make_unique<const Edges>(scene, radius_m)) {}
SurfaceBoundary::~SurfaceBoundary() = default;
SurfaceBoundary::SurfaceBoundary(SurfaceBoundary&&) noexcept = default;

float SurfaceBoundary::mass_on_surface(const Kernel& kernel, const vec3& p, const vec3& normal, float radius_m,
                                       float thickness_m) const {
    assert(radius_m <= edges_->radius_m && "edges farther off are not known to the cell of p");
    if (!edges_->tree.may_have_edges(p)) return 1;

    const float on_line_m = 1e-5f * radius_m + 2 * edges_->error_m;
    const Vec3Lanes n = broadcast(normal), centre = broadcast(p);
    Layer front_layer, back_layer;
    edges_->tree.visit_blocks(p, normal, radius_m, thickness_m, [&](const EdgeBlock& e) {
        // Which side of the surfaces the edges bound, if any: inside is left of a -> b, seen against the normal.
        const FloatLanes c = dot(e.normal.load(), n), other = dot(e.other_normal.load(), n);
        const FloatMask front = c >= kSameSurface, back = c <= -kSameSurface;
        const FloatMask of_front = front != (other >= kSameSurface),
                        of_back = !of_front && back != (other <= -kSameSurface);
        FloatMask bounds = of_front || of_back;
        if (none_of(bounds)) return;
        const FloatMask inside_left = (of_front && front) || (of_back && !back);

        // The edges in the tangent plane: lines at signed distance d, of which s0 ... s1 are the edges.
        const Vec3Lanes a = e.a.load() - centre, ab = e.ab.load();
        const FloatLanes height_a = dot(a, n), rise = dot(ab, n);
        const FloatLanes length_sq = dot(ab, ab) - rise * rise, area = dot(n, cross(a, ab));
        bounds = bounds && area * area < sqr(radius_m) * length_sq;
        if (none_of(bounds)) return;
        const FloatLanes per_length = 1.0f / sqrt(length_sq), d = area * per_length, distance = abs(d);
        bounds = bounds && distance > on_line_m;  // nearer: which side p is on cannot be told
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
                                  integrate_mass(kernel, distance, s0, s1, radius_m, counts);
        const FloatLanes lost = select(counts, select((d > 0) == inside_left, beyond, -beyond), 0);
        front_layer.add(bounds && of_front, height, lost);
        back_layer.add(bounds && of_back, height, lost);
    });
    // p lies on the layer whose edges are nearer to its plane; one sheet with both windings has both at equal height.
    const float front_lost = 0.5f * kInvPi * reduce(front_layer.lost),
                back_lost = 0.5f * kInvPi * reduce(back_layer.lost);
    const float front_height_m = hmin(front_layer.height_m), back_height_m = hmin(back_layer.height_m);
    const float difference_m = front_height_m - back_height_m;
    const float same_m = 1e-3f * radius_m + edges_->error_m;
    const float lost = std::fabs(difference_m) <= same_m ? std::max(front_lost, back_lost)
                       : difference_m < 0                ? front_lost
                                                         : back_lost;
    return std::clamp(1 - lost, kLeastMass, 1.0f);
}

size_t SurfaceBoundary::edges() const { return edges_->tree.size(); }

uint64_t SurfaceBoundary::bytes() const { return sizeof(Edges) + edges_->tree.bytes(); }

}  // namespace photond
