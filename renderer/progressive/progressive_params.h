#pragma once
// Parameters that the progressive photon mapping methods have in common, declared once.

#include <optional>

#include "protocol/param_info.h"
#include "renderer/photons/disc_coverage.h"
#include "renderer/photons/kernel.h"
#include "renderer/photons/radius_schedule.h"
#include "renderer/transport/sobol.h"

namespace photond {

/// How the radius of the density estimates shrinks from pass to pass (disc_radii.h).
enum class RadiusRule : uint8_t {
    Global,   // one radius for all points, by the pass's index
    Trained,  // one radius for each place, trained beforehand, times a factor by the pass's index
    Local,    // each point's own, by the photons it has counted
    Tested,   // each point's own, where the photons it has counted say that light is curved there
};
enum class CurvatureTest : uint8_t { Radial, Sector };

struct ProgressiveParams : MethodParams {
    uint32_t photons = 100'000;
    std::optional<uint32_t> caustic_photons;
    std::optional<uint32_t> indirect_bounces;
    RadiusRule radius_rule = RadiusRule::Trained;
    CurvatureTest test = CurvatureTest::Radial;
    float alpha = static_cast<float>(kRadiusAlpha);
    uint32_t nearest_photons = 50;
    std::optional<float> radius_m;
    std::optional<float> radius_relative;
    KernelShape kernel = KernelShape::Epanechnikov;
    float cone_k = 1.1f;
    std::optional<float> disc_thickness_m;
    DiscBoundary boundary = DiscBoundary::Clip;
    bool projection_maps = true;
    float glossy_threshold = 0.05f;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    /// `radius` and `radius_relative` exclude each other.
    void check() const override;

    /// Greatest number of scattering vertices of a path: n vertices make n - 1 bounces (conventions.md).
    uint32_t max_scatterings() const { return indirect_bounces ? *indirect_bounces + 1 : UINT32_MAX; }
    /// Scatterings left to a photon that is looked up after so many of the eye's path, the lookup's own included.
    uint32_t photon_scatterings(uint32_t scatterings) const {
        return max_scatterings() == UINT32_MAX ? UINT32_MAX
                                               : max_scatterings() - std::min(max_scatterings(), scatterings);
    }
    /// Whether a pass is the same whatever passes came before it.
    bool passes_stand_alone() const { return radius_rule == RadiusRule::Global || radius_rule == RadiusRule::Trained; }
    /// Of the first pass, where it is given; for a scene whose bounding sphere has that radius.
    std::optional<float> first_radius_m(float scene_radius_m) const;
};

}  // namespace photond
