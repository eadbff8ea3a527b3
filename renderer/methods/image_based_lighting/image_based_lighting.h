#pragma once
#include "renderer/frame/method.h"
#include "renderer/methods/image_based_lighting/params.h"
#include "renderer/methods/image_based_lighting/prefiltered_environment.h"

namespace photond {

/// Image-based lighting by the split sum, a baseline: what a surface makes of the environment is the product of two
/// things known beforehand, the environment blurred for its roughness (prefiltered_environment.h) and its lobes' shares
/// of light that is the same from everywhere (LobeAlbedos of transport/bsdf_evaluator.h, of the BSDF's own D, G and
/// layers). Diffuse lobes take the irradiance map, GGX lobes the map of their roughness in the mirrored direction, thin
/// sheets in the one straight through.
///
/// From the eye mirrors and smooth glass are followed to rough surfaces, which are lit where they are met. The
/// environment's light there is the layer `direct`, as that of other lights is: one sample with a shadow ray, beside a
/// ray of the lobes where lamps have an area and surfaces gloss. A pass differs from the next in its samples of the
/// pixel and of those lights alone.
///
/// Exact where the environment is the same from everywhere, for any surface; for Lambert reflectors under any. Else
/// wrong by what the split leaves out: the lobe is taken as seen straight on, so that it is not stretched towards
/// grazing angles and is not cut off at the horizon; under a coat, diffuse lobes take light of all angles alike
/// (tables: docs/image-based-lighting/README.md). Not in it at all: whether anything stands before the environment,
/// light that bounces, light of the environment through the rough interface of a solid.
///
/// [Karis 2013] Real Shading in Unreal Engine 4. SIGGRAPH course Physically Based Shading in Theory and Practice.
/// [Walter et al. 2007] Microfacet Models for Refraction through Rough Surfaces. EGSR.
class ImageBasedLighting final : public Method {
public:
    static constexpr const char* kName = "image_based_lighting";
    using Params = ImageBasedLightingParams;

    explicit ImageBasedLighting(const ImageBasedLightingParams& params);
    ~ImageBasedLighting() override;
    /// What begin() will record, to a few percent.
    static uint64_t estimate_bytes(const ImageBasedLightingParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    PassImage* end_pass() override;

private:
    struct State;  // image_based_lighting.cpp

    const ImageBasedLightingParams params_;
    std::unique_ptr<State> state_;
};

/// A path's first rough surface may be lit by what was scattered before: as much as makes the walk leave it.
inline constexpr uint32_t kImageBasedScatterings = 2;

PrefilterSettings prefilter_of(const ImageBasedLightingParams& params);
/// Bytes of the maps, and of what making them takes; none without an environment.
uint64_t prefilter_bytes(const ImageBasedLightingParams& params, Size2 environment_size);
/// Makes the maps in the stage `prefilter`, within the budget.
PrefilteredEnvironment prefilter_environment(const Scene& scene, const EnvironmentSampler& sampler,
                                             const ImageBasedLightingParams& params, MemoryBudget& budget,
                                             Stats& stats);
/// Says what is not asked of any scene, and what this one has no use for.
void note_skipped_by_image_based_lighting(const Scene& scene, const ImageBasedLightingParams& params, Stats& stats);

}  // namespace photond
