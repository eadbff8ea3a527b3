#include "renderer/photons/surface_boundary.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "renderer/photons/boundary_tree.h"

namespace photond {

namespace {

constexpr float kSameSurface = 0.5f;  // cosine of the disc test's 60 degrees

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
    struct Layer {
        float lost = 0;
        float height_m = kInfinity;  // least distance of an edge from the tangent plane
    };
    std::array<Layer, 2> layers;
    edges_->tree.visit_edges(p, normal, radius_m, thickness_m, [&](const BoundaryEdge& e) {
        const Turn turn = turn_of(e, normal);
        if (turn.sign == 0) return;

        // The edge in the tangent plane: line at signed distance d, of which s0 ... s1 is the edge.
        const vec3 a = e.a - p, ab = e.b - e.a;
        const float height_a = glm::dot(a, normal), rise = glm::dot(ab, normal);
        const float length_sq = glm::dot(ab, ab) - sqr(rise);
        const float area = glm::dot(normal, glm::cross(a, ab));
        if (!(sqr(area) < sqr(radius_m) * length_sq)) return;
        const float length = std::sqrt(length_sq), d = area / length;
        if (std::fabs(d) <= on_line_m) return;  // which side p is on cannot be told
        const float start = (glm::dot(a, ab) - height_a * rise) / length;
        const float half_chord = std::sqrt(sqr(radius_m) - sqr(d));
        float s0 = std::max(start, -half_chord), s1 = std::min(start + length, half_chord);

        // The part of it within the thickness of the disc.
        const float slope = rise / length;
        if (std::fabs(height_a) > thickness_m || std::fabs(height_a + rise) > thickness_m) {
            if (slope == 0) return;
            const float t0 = start + (-thickness_m - height_a) / slope, t1 = start + (thickness_m - height_a) / slope;
            s0 = std::max(s0, std::min(t0, t1)), s1 = std::min(s1, std::max(t0, t1));
        }
        if (!(s0 < s1)) return;

        Layer& layer = layers[turn.layer];
        layer.height_m = std::min(layer.height_m, std::fabs(height_a + slope * (std::clamp(0.0f, s0, s1) - start)));
        if (e.continues_at_m <= thickness_m) return;
        const float beyond = mass_beyond(kernel, std::fabs(d), s0, s1, radius_m);
        layer.lost += (d > 0) == (turn.sign > 0) ? beyond : -beyond;
    });
    // p lies on the layer whose edges are nearer to its plane; one sheet with both windings has both at equal height.
    const float difference_m = layers[0].height_m - layers[1].height_m;
    const float same_m = 1e-3f * radius_m + edges_->error_m;
    const float lost = std::fabs(difference_m) <= same_m ? std::max(layers[0].lost, layers[1].lost)
                       : difference_m < 0                ? layers[0].lost
                                                         : layers[1].lost;
    return std::clamp(1 - lost, kLeastMass, 1.0f);
}

size_t SurfaceBoundary::edges() const { return edges_->tree.size(); }

uint64_t SurfaceBoundary::bytes() const { return sizeof(Edges) + edges_->tree.bytes(); }

}  // namespace photond
