#pragma once
#include <optional>

#include "renderer/methods/method.h"
#include "renderer/photons/kernel.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/transport/sobol.h"

namespace photond {

enum class SplatWeighting : uint8_t { Normalised, Radiometric };
enum class SplatEstimator : uint8_t { Connect, Kernel };
enum class SplatFilter : uint8_t { Box, Tent, Gaussian };
enum class Representative : uint8_t { Random, ByPower, ClosestToMean, DominantDirection };
enum class BlurWidth : uint8_t { None, Three, Five, Seven, Nine };

struct PhotonSplattingParams final : MethodParams {
    uint32_t photons = 20'000;
    uint32_t bounces = 1;
    PhotonInjection injection = PhotonInjection::Paths;
    uint32_t rays_per_photon = 1;
    bool stratify = false;
    uint32_t grid_cells = 64;
    uint32_t minimum_photons = 2;
    uint32_t splats_per_cell = 1;
    Representative representative = Representative::ByPower;
    std::optional<float> splat_size_m;
    std::optional<float> splat_size_relative;
    SplatFilter filter = SplatFilter::Box;
    SplatWeighting weighting = SplatWeighting::Radiometric;
    SplatEstimator estimator = SplatEstimator::Connect;
    std::optional<float> step_back_m;
    std::optional<float> splat_depth_m;
    uint32_t shadow_resolution = 16;
    bool visibility = true;
    std::optional<bool> shrink;
    float alpha = 2.0f / 3.0f;
    bool repay = true;
    BlurWidth blur = BlurWidth::None;
    bool blur_edges = false;
    float ambient = 0;
    float indirect_exposure = 1;
    float glossy_threshold = 0.05f;
    float connect_threshold = 0.2f;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    /// Parameters that exclude each other.
    void check() const override;

    bool connects() const { return weighting == SplatWeighting::Radiometric && estimator == SplatEstimator::Connect; }
    /// Greatest number of scattering vertices of a path (conventions.md: n vertices make n - 1 bounces).
    uint32_t max_scatterings() const { return bounces + 1; }
};

}  // namespace photond
