#pragma once
#include <optional>

#include "renderer/methods/method.h"
#include "renderer/methods/vpl_lighting.h"
#include "renderer/transport/sobol.h"

namespace photond {

enum class VplChoice : uint8_t { Interleaved, Lightcut, Resampled };
enum class VplPlacement : uint8_t { Flux, Camera };
enum class VplBounces : uint8_t { Voxels, Rays };
enum class DirectShadows : uint8_t { Rays, ShadowMaps };

struct SvoManyLightsParams final : MethodParams {
    uint32_t vpls = 1024;
    uint32_t bounces = 1;
    uint32_t map_resolution = 128;
    VplPlacement placement = VplPlacement::Flux;
    VplBounces bounce_tracing = VplBounces::Rays;
    VplVisibility visibility = VplVisibility::Svo;
    uint32_t voxel_resolution = 256;
    uint32_t shadow_resolution = 32;
    VplChoice vpl_choice = VplChoice::Interleaved;
    uint32_t interleave = 4;
    uint32_t cut_size = 64;
    uint32_t resampled_vpls = 8;
    float roulette = 0.1f;
    std::optional<float> clamp_m2;
    bool repay = true;
    uint32_t filter = 0;
    float filter_normal = 0.9f;
    float filter_distance = 0.02f;
    DirectShadows direct = DirectShadows::Rays;
    uint32_t direct_resolution = 1024;
    uint32_t pcf = 3;
    float glossy_threshold = 0.05f;
    float connect_threshold = 0.2f;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    void check() const override;

    /// Of a path (conventions.md: n vertices make n - 1 bounces).
    uint32_t max_scatterings() const { return bounces + 1; }
    bool needs_voxels() const {
        return visibility == VplVisibility::Svo || (bounces > 1 && bounce_tracing == VplBounces::Voxels);
    }
    /// Pixels along a side of the blocks whose pixels share out the lights.
    uint32_t split_side() const { return vpl_choice == VplChoice::Interleaved ? interleave : 1; }
};

}  // namespace photond
