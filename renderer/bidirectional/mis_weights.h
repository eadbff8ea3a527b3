#pragma once
// Weights of multiple importance sampling among all ways to make one path: the eye meets the light, next-event
// estimation, connections of two sub-paths, light paths seen by the camera, and merging.
//
// Each sub-path carries, from vertex to vertex, what the other techniques that share it so far would have had as
// density, over its own. Radii, connections and merging may differ from pixel to pixel, but weights are linear in the
// techniques' numbers: three sums are carried apart (SubpathWeights), and put together by the numbers of the pixel that
// the path is for (TechniqueNumbers). Merging acceptances carry their place's own radius.
//
// Russian roulette is in no density: contributions are divided by it. Delta scatterings have the same probability both
// ways (vertex_scattering.h) and drop out. Densities of light samples depend on the point that is lit here, and on a
// choice that differs from the one photons are emitted by: the two never cancel.
//
// `Real` is float in the renderer; tests compile the same recursion in double.
//
// [Veach 1997, ch. 9, 10] Robust Monte Carlo Methods for Light Transport Simulation. [Georgiev, Krivanek, Davidovic,
// Slusallek 2012] Light Transport Simulation with Vertex Connection and Merging. ACM TOG 31(6). [Georgiev 2012]
// Implementing Vertex Connection and Merging. Technical report: dVCM is `last`, dVC are the three sums, and dVM is dVC
// over the merging acceptance.

#include <cstdint>

#include "renderer/transport/light_ends.h"

namespace photond {

enum class MisHeuristic : uint8_t { Balance, Power };

/// How many samples of each technique there are for a pixel, next-event estimation and meeting the light being one.
/// Sub-paths know nothing of these: the same ones can be weighed for any.
template <class Real>
struct BasicTechniqueNumbers {
    Real light_paths = 0;  // of a pass: each is a sample of every pixel that sees it, and can be merged with
    Real connections = 1;  // expected, of an eye vertex with each vertex of one light path
    bool merges = false;
    Real caustic_radius = 1;  // where light merges that was scattered at least once, and by delta lobes: of the radius

    /// ... as the share of the acceptance.
    Real caustic_area() const { return caustic_radius * caustic_radius; }
    bool operator==(const BasicTechniqueNumbers&) const = default;
};
using TechniqueNumbers = BasicTechniqueNumbers<float>;

/// What a sub-path carries to its newest vertex: ratios of densities to its own, by the heuristic. Those in the sums
/// lack the density with which a path that comes the other way scatters at that vertex.
template <class Real>
struct BasicSubpathWeights {
    Real last = 0;         // of the technique that ends this sub-path one vertex earlier
    Real ends = 0;         // of a light path: light met and next event; of the eye's: seen by the camera
    Real connections = 0;  // with one connection each
    Real merges = 0;       // with one light path and the acceptance of their places, pi r^2
    // Of the eye's: what its newest vertex that is no delta adds to merges. Where the path then meets the light by
    // delta lobes, what could have merged there is a caustic.
    Real newest_merge = 0;
};
using SubpathWeights = BasicSubpathWeights<float>;

/// One side of a vertex that two sub-paths meet at.
template <class Real>
struct BasicVertexSide {
    bool first_surface;  // of its sub-path
    Real pdf_back;       // [1/sr] of scattering back along the sub-path, for a path that comes the other way
    Real acceptance;     // of merging here: pi r^2 [m^2]
};
using VertexSide = BasicVertexSide<float>;

/// The density of the technique that made a path beside that of all others that could have, both by the heuristic and
/// over the technique's for one sample of it (merging: for one light path and an acceptance of 1).
template <class Real>
struct BasicMisShare {
    Real own, others;

    Real all() const { return own + others; }
    /// Not where densities leave the range of Real.
    Real weight() const {
        const Real share = own / all();
        return share >= 0 ? share : Real(0);
    }
    operator Real() const { return weight(); }
};
using MisShare = BasicMisShare<float>;

template <class Real>
class BasicMis {
public:
    using Share = BasicMisShare<Real>;
    using Weights = BasicSubpathWeights<Real>;
    using Numbers = BasicTechniqueNumbers<Real>;
    using Side = BasicVertexSide<Real>;
    using End = BasicLightEnd<Real>;

    explicit BasicMis(MisHeuristic heuristic) : squares_(heuristic == MisHeuristic::Power) {}
    MisHeuristic heuristic() const { return squares_ ? MisHeuristic::Power : MisHeuristic::Balance; }

    /// A light path, at its light. To be told when its first hit is known: direct_at_first_hit().
    Weights start_light(const End& end) const {
        return {.last = of(1 / end.emission),
                .ends = end.delta ? Real(0) : of((end.infinite ? Real(1) : end.cosine) / end.emission)};
    }
    void direct_at_first_hit(Weights& w, Real direct) const { w.last *= of(direct); }
    /// An eye path. `camera_pdf`: of its direction in solid angle, or of its place in area (orthographic), for an image
    /// whose pixel has the area one.
    Weights start_eye(Real camera_pdf) const { return {.last = of(1 / camera_pdf)}; }

    /// At the next surface. `distance_sq_m2`: 1 for the first edge from an infinite light or an orthographic camera.
    void arrive(Weights& w, Real distance_sq_m2, Real cos_at_surface) const {
        const Real inverse_cos = of(1 / cos_at_surface);
        w.last *= of(distance_sq_m2) * inverse_cos;
        w.ends *= inverse_cos, w.connections *= inverse_cos, w.merges *= inverse_cos;
        w.newest_merge *= inverse_cos;
    }
    /// The path goes on from a vertex where it was drawn with `pdf` [1/sr]. `cos_out` against the geometric normal.
    void scatter(Weights& w, const Side& side, Real pdf, Real cos_out) const {
        const Real out = of(cos_out / pdf), back = of(side.pdf_back);
        w.ends = out * (w.ends * back + (side.first_surface ? w.last : Real(0)));
        w.connections = out * (w.connections * back + (side.first_surface ? Real(0) : w.last));
        w.newest_merge = out * of(side.acceptance);
        w.merges = out * (w.merges * back) + w.newest_merge;
        w.last = of(1 / pdf);
    }
    /// The same by a delta lobe: this vertex can neither be connected nor merged with.
    void scatter_delta(Weights& w, Real cos_out) const {
        const Real out = of(cos_out);
        w.last = 0;
        w.ends *= out, w.connections *= out, w.merges *= out, w.newest_merge *= out;
    }

    /// The eye's path met a light, not at its first vertex; `eye` as after arrive() there, infinite: after scatter().
    Share light_met(Weights eye, const End& end, const Numbers& n) const {
        const bool by_delta = eye.last == 0;
        if (by_delta) eye.merges -= eye.newest_merge * (1 - of(n.caustic_area()));
        return share(1, of(end.direct) * eye.last + of(end.emission) * sum_of_eye(eye, n));
    }
    /// Next-event estimation at a surface vertex of the eye's path. `pdf`: of the light's direction by the BSDF;
    /// `pdf_direct_sa`: by the light sample (points, spots: their choice times the squared distance; directional: the
    /// choice); `cosine`: at the vertex, against its geometric normal.
    Share next_event(const Weights& eye, const Side& side, Real pdf, Real pdf_direct_sa, Real cosine, const End& end,
                     const Numbers& n) const {
        const Real by_bsdf = end.delta ? Real(0) : of(pdf / pdf_direct_sa);
        const Real emitted = of(end.emission * cosine / (pdf_direct_sa * end.cosine));
        return share(1, by_bsdf + emitted * (merge(side, n) + others_of_eye(eye, side, n)));
    }
    /// A surface vertex of a light path as the camera sees it. `camera_pdf_area` [1/m^2]: start_eye()'s, per area of
    /// the surface.
    Share seen_by_camera(const Weights& light, const Side& side, Real camera_pdf_area, const Numbers& n) const {
        return share(of(n.light_paths), of(camera_pdf_area) * (merge(side, n) + others_of_light(light, side, n)));
    }
    /// A connection. `to_light_pdf_area`: with which the eye's path would have gone to the light path's vertex [1/m^2],
    /// and `to_eye_pdf_area` the other way round.
    Share connection(const Weights& eye, const Side& eye_side, Real to_light_pdf_area, const Weights& light,
                     const Side& light_side, Real to_eye_pdf_area, const Numbers& n) const {
        return share(of(n.connections),
                     of(to_light_pdf_area) * (merge(light_side, n) + others_of_light(light, light_side, n)) +
                         of(to_eye_pdf_area) * (merge(eye_side, n) + others_of_eye(eye, eye_side, n)));
    }
    /// Merging of two vertices into one, with the acceptance of the eye's. `light_side.pdf_back`: of the eye's path to
    /// where the light path came from; `eye_side.pdf_back`: of the light path to the eye.
    Share merging(const Weights& eye, const Side& eye_side, const Weights& light, const Side& light_side,
                  const Numbers& n) const {
        return share(merge(eye_side, n), others_of_light(light, light_side, n) + others_of_eye(eye, eye_side, n));
    }

private:
    Real of(Real ratio) const { return squares_ ? ratio * ratio : ratio; }
    static Share share(Real own, Real others) { return {own, others}; }
    /// Merging at a vertex.
    Real merge(const Side& side, const Numbers& n) const {
        return n.merges ? of(n.light_paths * side.acceptance) : Real(0);
    }
    /// Techniques on one side of the newest vertex, but for the one that ends the sub-path one vertex earlier.
    Real sum_of_light(const Weights& w, const Numbers& n) const {
        return w.ends + of(n.connections) * w.connections + (n.merges ? of(n.light_paths) * w.merges : Real(0));
    }
    Real sum_of_eye(const Weights& w, const Numbers& n) const {
        return of(n.light_paths) * (w.ends + (n.merges ? w.merges : Real(0))) + of(n.connections) * w.connections;
    }
    /// All of this side. What ends a sub-path before its first surface is next-event estimation, or the camera.
    Real others_of_light(const Weights& w, const Side& side, const Numbers& n) const {
        return (side.first_surface ? w.last : of(n.connections) * w.last) + of(side.pdf_back) * sum_of_light(w, n);
    }
    Real others_of_eye(const Weights& w, const Side& side, const Numbers& n) const {
        return of(side.first_surface ? n.light_paths : n.connections) * w.last + of(side.pdf_back) * sum_of_eye(w, n);
    }

    const bool squares_;
};
using Mis = BasicMis<float>;

}  // namespace photond
