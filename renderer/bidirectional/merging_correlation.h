#pragma once
// What merging is worth where few light paths arrive. All eye paths that merge with the vertices of one light path are
// correlated: plain weights count each of the n light paths as a sample of its own, and leave blotches where a few of
// them meet a region that many eye paths see. Correlation-aware weights multiply the density of merging at a vertex by
// the share kappa = P_c / (P_c + P_l - P_c P_l), at least 1/n, where P_c and P_l say how surely the camera's and the
// light's sub-path come within a small region around that vertex: products, along each of them, of min(1, p a), p being
// its densities by area and a the area that the camera sees of one degree's radius at the path's first surface. At
// that surface it is 1, and where both are 0 [Grittmann et al. 2021, Sec. 4].
//
// The share of one vertex depends on the whole path, which the three sums of mis_weights.h cannot know. So sub-paths
// keep their vertices, and where two of them are joined, the sum over merging is made again from those; connections
// and ends keep their sums.
//
// [Grittmann, Georgiev, Slusallek 2021] Correlation-Aware Multiple Importance Sampling for Bidirectional Rendering
// Algorithms. Computer Graphics Forum 40(2).

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "renderer/bidirectional/mis_weights.h"

namespace photond {

/// A surface vertex of a sub-path, and how the path went on from it. All of it, but what says so, as it is before the
/// heuristic.
template <class Real>
struct BasicPathVertex {
    // Of the path coming here [1/m^2], infinite by a delta lobe; [1/m^4] of a light path's first vertex together with
    // that path's start on a surface.
    Real density = 0;
    bool of_two_areas = false;
    Real acceptance = 0;   // of merging here [m^2]
    Real inverse_cos = 0;  // of its arrival, against the geometric normal
    Real onward = 0;       // the cosine with which it went on over the density [sr]; of delta lobes the cosine
    Real pdf_back = 0;     // [1/sr] of a path that comes the other way, scattering here
    Real per_area = 0;     // the cosine with which it went on over the squared distance to the next vertex [1/m^2]
    bool delta = false;    // how it went on
    Real reach = 0;        // of all vertices up to this one: find_reach()

    /// `pdf` [1/sr], infinite by a delta lobe. per_area is still to be divided by the squared distance.
    void go_on(Real cosine, Real pdf, Real pdf_of_way_back) {
        delta = !(pdf < std::numeric_limits<Real>::infinity());
        onward = delta ? cosine : cosine / pdf;
        pdf_back = pdf_of_way_back;
        per_area = cosine;
    }
};
using PathVertex = BasicPathVertex<float>;

/// A light path at its first surface, from a light that lies `distance_sq_m2` before it and is met at that cosine.
template <class Real>
BasicPathVertex<Real> first_of_light(const BasicLightEnd<Real>& end, Real cosine, Real distance_sq_m2) {
    return {.density = end.emission * cosine / (end.infinite ? Real(1) : distance_sq_m2),
            .of_two_areas = !end.infinite && !end.delta};
}

/// What replaces SubpathWeights::merges and VertexSide::acceptance where two sub-paths are joined.
template <class Real>
struct BasicCorrelatedMerges {
    Real eye = 0, light = 0;              // before the vertex that is joined
    Real eye_share = 1, light_share = 1;  // kappa of the joined vertices
};
using CorrelatedMerges = BasicCorrelatedMerges<float>;

template <class Real>
class BasicMergingCorrelation {
public:
    using Vertex = BasicPathVertex<Real>;
    using Merges = BasicCorrelatedMerges<Real>;

    /// `first_distance_m`: from the camera to the eye path's first surface.
    BasicMergingCorrelation(MisHeuristic heuristic, Real first_distance_m, Real light_paths)
        : squares_(heuristic == MisHeuristic::Power),
          region_m2_(region_m2(first_distance_m)),
          least_(1 / light_paths) {}

    /// From the sub-path's first surface to its newest.
    void find_reach(std::span<Vertex> path) const {
        Real reach = 1;
        for (Vertex& vertex : path) vertex.reach = reach *= within(vertex);
    }

    // Sub-paths from their first surfaces to those that are joined, with their reach. Densities as in BasicMis.

    Merges connection(std::span<const Vertex> eye, Real eye_pdf_back, Real to_light_pdf_area,
                      std::span<const Vertex> light, Real light_pdf_back, Real to_eye_pdf_area) const {
        const Real at_eye = light.back().reach * within(to_eye_pdf_area);
        const Real at_light = eye.back().reach * within(to_light_pdf_area);
        return {.eye = before(eye, eye_pdf_back, at_eye, Side::Eye),
                .light = before(light, light_pdf_back, at_light, Side::Light),
                .eye_share = eye_share(eye, at_eye),
                .light_share = share(at_light, light.back().reach)};
    }
    /// Both end at one place; what counts for the weight is the eye's share.
    Merges merging(std::span<const Vertex> eye, Real eye_pdf_back, std::span<const Vertex> light,
                   Real light_pdf_back) const {
        return {.eye = before(eye, eye_pdf_back, light.back().reach, Side::Eye),
                .light = before(light, light_pdf_back, eye.back().reach, Side::Light),
                .eye_share = eye_share(eye, light.back().reach)};
    }
    /// `first`: the surface, as a light path would have met it first: first_of_light().
    Merges next_event(std::span<const Vertex> eye, Real eye_pdf_back, const Vertex& first) const {
        const Real at_eye = within(first);
        return {.eye = before(eye, eye_pdf_back, at_eye, Side::Eye), .eye_share = eye_share(eye, at_eye)};
    }
    /// `eye` until the last surface before the light, which is `first`. `inverse_cos`: of the arrival at the light; 1
    /// where that is infinite. `caustic_area`: of the technique's numbers.
    Merges light_met(std::span<const Vertex> eye, Real inverse_cos, const Vertex& first, Real caustic_area) const {
        return {.eye = sum(eye, inverse_cos, within(first), Side::Eye, eye.back().delta ? caustic_area : Real(1))};
    }
    Merges seen_by_camera(std::span<const Vertex> light, Real light_pdf_back, Real camera_pdf_area) const {
        return {.light = before(light, light_pdf_back, within(camera_pdf_area), Side::Light)};
    }

private:
    enum class Side { Eye, Light };

    static Real region_m2(Real distance_m) {
        const double tangent = std::tan(std::numbers::pi / 180);
        return static_cast<Real>(std::numbers::pi * tangent * tangent) * distance_m * distance_m;
    }
    Real of(Real ratio) const { return squares_ ? ratio * ratio : ratio; }
    Real within(Real density) const { return std::min(Real(1), density * region_m2_); }
    Real within(const Vertex& vertex) const {
        return within(vertex.of_two_areas ? vertex.density * region_m2_ : vertex.density);
    }
    Real share(Real camera, Real light) const {
        const Real either = camera + light - camera * light;
        return either > 0 ? std::max(camera / either, least_) : Real(1);
    }
    Real eye_share(std::span<const Vertex> eye, Real light) const {
        return eye.size() == 1 ? Real(1) : share(eye.back().reach, light);
    }

    /// Merging before the last vertex, to which the other sub-path has that reach.
    Real before(std::span<const Vertex> path, Real pdf_back, Real reach, Side side) const {
        if (path.size() < 2) return 0;
        const std::span<const Vertex> earlier = path.first(path.size() - 1);
        return sum(earlier, path.back().inverse_cos, reach * within(pdf_back * earlier.back().per_area), side);
    }
    /// At all vertices of `path`, which went on to one where it arrived at 1/inverse_cos; the other sub-path has that
    /// reach to its last. `newest_area`: of the acceptance, at the newest where they can merge.
    Real sum(std::span<const Vertex> path, Real inverse_cos, Real reach, Side side, Real newest_area = 1) const {
        Real merges = 0, ratio = 1;
        for (size_t i = path.size(); i-- > 0;) {
            const Vertex& vertex = path[i];
            ratio *= of(vertex.onward * inverse_cos);
            inverse_cos = vertex.inverse_cos;
            if (vertex.delta) continue;
            const Real kappa = side == Side::Light ? share(reach, vertex.reach)
                               : i == 0            ? Real(1)
                                                   : share(vertex.reach, reach);
            merges += ratio * of(vertex.acceptance * kappa * newest_area);
            newest_area = 1;
            ratio *= of(vertex.pdf_back);
            if (i > 0) reach *= within(vertex.pdf_back * path[i - 1].per_area);
        }
        return merges;
    }

    const bool squares_;
    const Real region_m2_;
    const Real least_;
};
using MergingCorrelation = BasicMergingCorrelation<float>;

}  // namespace photond
