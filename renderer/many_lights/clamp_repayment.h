#pragma once
// What connections leave out, given back.
//
// A connection over a distance d counts as if it were at least sqrt(B) (derivations.md, "The VPL clamp and its exact
// repayment"). What is missing at x is
//   int L_o(y) f(x) cos_x (1 - d^2/B)^+ dw,
// L_o the light that connects from y: scattered there by its rough part, of as many bounces as lights may have. One
// cosine-distributed ray of length sqrt(B) a visible point finds y; light samples there, and for more bounces a path on
// from there, find L_o.
//
// The narrow lobes of y, which do not connect, can be asked by the same ray, which then has no end: the light they
// scatter towards x is found likewise, a path by them to what they show among it. Connections, what the clamp takes and
// this are all the light that comes to x from surfaces.
//
// Lights that such a path meets behind a specular scattering (caustics, seen from their end) make rare bright dots.
// With a map of caustic photons (photons/caustic_photons.h) they do not count: what specular scatterings alone brought
// to a vertex is looked up there, at all vertices but x, which is the caller's to look up. GPU twin:
// clamp_repayment.glsl.

#include <span>

#include "renderer/eye/eye_scene.h"
#include "renderer/eye/visible_point.h"
#include "renderer/photons/caustic_photons.h"
#include "renderer/transport/path_batch.h"

namespace photond {

/// A visible point that connections to which were clamped.
struct ClampedPoint {
    vec3 position;                // world [m]
    vec3 geometric_normal;        // unit, on the eye's side
    vec3 normal;                  // that shades
    const VisiblePoint* general;  // null: Lambert
    uint32_t pixel;
    uint32_t most_scatterings;  // of the light that connects
};

/// What all threads share.
struct RepaymentScene {
    const EyeScene& eye;
    float connect_threshold;  // of the rough part that connects: GGX alpha above it
    /// Null: lights are met behind specular scatterings. Its threshold is no greater than that of connections.
    const CausticMap* caustics = nullptr;
};

/// Where the light is added: irradiance of Lambert points, radiance before the throughput of others. An empty span: it
/// is not asked for.
struct LeftOut {
    std::span<Rgb> clamped, narrow;
};

/// Scratch of one thread.
class ClampRepayment {
public:
    /// Adds to the sums at i what connections with B = `clamp_sq_m2` leave out at points[i]. Rays go to `counts` as
    /// bounce and shadow rays. `sampler`: numbers of the pass, of RandomDomain::Splats.
    void repay(const RepaymentScene& shared, const PassSampler& sampler, std::span<const ClampedPoint> points,
               float clamp_sq_m2, const LeftOut& left_out, Counts& counts);

private:
    struct Path {
        Rgb throughput;  // radiance at the end becomes what is added to the point's sum
        uint32_t point;
        float pdf_sa = 0;  // of the direction, against light samples
        bool delta = false;
        bool narrow = false;  // for LeftOut::narrow
        bool blind = false;   // came by lobes behind which lights do not count
        uint32_t left = 0;    // scatterings that lights may have had, the one at the next vertex included
        vec3 position{0}, lit_normal{0};
        MediumStack media;
    };
    struct Light {
        Rgb light;
        uint32_t point;
        bool narrow;
    };
    /// What the path may do at a vertex: scatter by some of the lobes there. It goes on by one part at the most.
    struct Part {
        Bsdf bsdf;
        float share = 1;  // of what it scatters
        bool narrow = false;
        bool blind = false;  // lights are neither sampled for it nor met by it
        float weight = 0;    // of the choice to go on by it; 0: not by it
    };

    void start(const PassSampler& sampler, std::span<const ClampedPoint> points);
    void scatter(const RepaymentScene& shared, const PassSampler& sampler, uint32_t vertex, size_t i);
    void list_first_parts(const RepaymentScene& shared, const Path& path, const Bsdf& whole, float clamped_share);
    void list_parts(const RepaymentScene& shared, const Path& path, const Bsdf& whole);
    void add_part(const Path& path, const Bsdf& bsdf, bool narrow, bool blind, float share, bool may_meet_lights);
    void add_light_met(const RepaymentScene& shared, const Path& path, const Hit& hit, const vec3& direction);
    void leave(const PassSampler& sampler, uint32_t key, uint32_t vertex, const Path& path, const ShadingPoint& at,
               const Part& part, const vec3& wo, float chance, const vec2& choice);
    void sample_light(const RepaymentScene& shared, const PassSampler& sampler, uint32_t key, uint32_t vertex,
                      const Path& path, const ShadingPoint& at, const Bsdf& bsdf, const vec3& wo, float goes_on);
    void add(uint32_t point, bool narrow, const Rgb& light);

    LeftOut left_out_;
    float clamp_sq_m2_ = 0;    // B
    std::vector<Part> parts_;  // of the vertex
    PathBatch<Path> batch_;
    ShadowBatch<Light> shadows_;
    Neighbours neighbours_;
};

}  // namespace photond
