#pragma once
// The radii of the discs that density is estimated on, and how they shrink from pass to pass.
//
// Whatever the rule, the image is the plain mean of the passes, each estimated with the radius that it began with. For
// [Hachisuka et al. 2008]'s statistics this is the same as their own: with tau <- (tau + tau_M) r_new^2 / r_old^2, the
// estimate tau / (pi r^2 N) is the mean of the passes' tau_M / (pi r_old^2). So the state of a rule is its radii, and
// what it has counted for the next one.
//
// [Hachisuka, Ogaki, Jensen 2008] Progressive Photon Mapping. ACM TOG 27(5).
// [Hachisuka and Jensen 2009] Stochastic Progressive Photon Mapping. ACM TOG 28(5).
// [Knaus and Zwicker 2011] Progressive Photon Mapping: A Probabilistic Approach. ACM TOG 30(3).
// [Kaplanyan and Dachsbacher 2013] Adaptive Progressive Photon Mapping. ACM TOG 32(2).
// [Lin et al. 2020] CPPM: Chi-squared Progressive Photon Mapping. ACM TOG 39(6).

#include <memory>
#include <optional>
#include <string>

#include "renderer/eye/visible_point.h"
#include "renderer/photons/radiance_estimate.h"
#include "renderer/progressive/progressive_photons.h"

namespace photond {

/// A lookup that asks for its radius.
struct DiscPlace {
    vec3 position;   // world [m]
    uint32_t pixel;  // of the image
    uint32_t turn;   // a random number
};

/// All radii of one render. Within a pass different pixels may be asked by different threads.
class DiscRadii {
public:
    virtual ~DiscRadii() = default;

    /// Of all discs of the pass begun, where most are about as large: a grid of cells of that size finds their photons.
    virtual std::optional<float> grid_radius_m(PhotonMapKind /*kind*/) const { return std::nullopt; }
    /// Before the lookups of a pass. What an unfinished pass gathered is forgotten.
    virtual void begin_pass(uint32_t pass) = 0;
    /// In the pass begun. [m], > 0. `scratch` is the calling thread's.
    virtual float radius_m(PhotonMapKind kind, const DiscPlace& place, Neighbours& scratch) = 0;
    /// Whether gathered() wants to know the moments of each disc.
    virtual bool wants_moments() const { return false; }
    /// What the disc that was asked for held.
    virtual void gathered(PhotonMapKind /*kind*/, const DiscPlace& /*place*/, const RadianceEstimate& /*estimate*/,
                          const DiscMoments& /*moments*/) {}
    /// The pass is part of the image: what it gathered counts from now on.
    virtual void end_pass() {}

    /// What later passes follow from, beside scene, parameters and seed. Empty where there is nothing.
    virtual std::string state() const { return {}; }
    virtual uint64_t bytes() const = 0;
};

/// What the rules are made from.
struct DiscRadiiInputs {
    const RenderContext& context;
    const ProgressiveParams& params;
    ProgressivePhotons& photons;
    uint32_t hit_point_sets;   // of a pixel that have radii of their own, one pass after the other; 1: all share
    const std::string& state;  // to go on from; empty: from the beginning
};

/// By params.radius_rule. Traces pilots where the first radius is not given. Throws ErrorCode::Conflict for a state
/// that is not of these inputs.
std::unique_ptr<DiscRadii> make_disc_radii(const DiscRadiiInputs& inputs, Stats& stats);
/// What a rule takes, at most.
struct DiscRadiiBytes {
    uint64_t kept = 0;    // while passes are rendered
    uint64_t before = 0;  // beside that, before the first pass has its photons
    uint64_t state = 0;   // as it is saved
};
DiscRadiiBytes disc_radii_bytes(const ProgressiveParams& params, uint32_t hit_point_sets, const Workload& workload);

/// Radii of at most and at least this, by the radius of the scene's bounding sphere. [m]
struct RadiusLimits {
    explicit RadiusLimits(float scene_radius_m);
    float least_m, most_m;
};

}  // namespace photond
