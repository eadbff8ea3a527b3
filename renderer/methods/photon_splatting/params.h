#pragma once
// The parameters of photon splatting: each is a field here, and a line of visit().

#include <algorithm>
#include <optional>

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/photons/kernel.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/transport/sobol.h"

namespace photond {

enum class SplatWeighting : uint8_t { Normalised, Radiometric };
enum class SplatEstimator : uint8_t { Connect, Kernel };
enum class SplatFilter : uint8_t { Box, Tent, Gaussian };
enum class Representative : uint8_t { Random, ByPower, ClosestToMean, DominantDirection };
enum class BlurWidth : uint8_t { None, Three, Five, Seven, Nine };
/// Pixels across; 0: none.
constexpr uint32_t blur_pixels(BlurWidth width) {
    return width == BlurWidth::None ? 0 : 2 * static_cast<uint32_t>(width) + 1;
}

struct PhotonSplattingParams final : MethodParams {
    TemporalParams temporal;
    static constexpr uint32_t kMostBounces = 254;  // a photon's scatterings are a byte

    uint32_t photons = 10'000;
    uint32_t bounces = kMostBounces;
    PhotonInjection injection = PhotonInjection::Paths;
    uint32_t rays_per_photon = 1;
    bool stratify = false;
    uint32_t grid_cells = 64;
    uint32_t minimum_photons = 1;
    uint32_t splats_per_cell = 1;
    Representative representative = Representative::ByPower;
    std::optional<float> splat_size_m;
    std::optional<float> splat_size_relative;
    bool adaptive_size = true;
    SplatFilter filter = SplatFilter::Box;
    SplatWeighting weighting = SplatWeighting::Radiometric;
    SplatEstimator estimator = SplatEstimator::Connect;
    std::optional<float> step_back_m;
    std::optional<float> splat_depth_m;
    uint32_t shadow_resolution = 16;
    bool visibility = true;
    bool shrink = true;
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
    /// Whether beams become narrower from pass to pass.
    bool shrinks() const { return shrink && weighting == SplatWeighting::Radiometric; }
    /// Of photons: lobes with GGX alpha below it send beams.
    float photon_threshold() const {
        return connects() ? std::max(connect_threshold, glossy_threshold) : glossy_threshold;
    }
    /// Greatest number of scattering vertices of a path: n vertices make n - 1 bounces (conventions.md).
    uint32_t max_scatterings() const { return bounces + 1; }
};

inline void PhotonSplattingParams::visit(ParamVisitor& visitor) {
    using enum ParamGroup;
    static constexpr std::string_view kInjections[] = {"paths", "reflective_shadow_map"};
    static constexpr std::string_view kRepresentatives[] = {"random", "by_power", "closest_to_mean",
                                                            "dominant_direction"};
    static constexpr std::string_view kFilters[] = {"box", "tent", "gaussian"};
    static constexpr std::string_view kWeightings[] = {"normalised", "radiometric"};
    static constexpr std::string_view kEstimators[] = {"connect", "kernel"};
    static constexpr std::string_view kBlurs[] = {"none", "3", "5", "7", "9"};

    visitor.field("photons", photons, {Light, "photons", 1, 1e9, "light paths a pass"});
    visitor.field("bounces", bounces,
                  {Light, "", 0, kMostBounces, "greatest number of bounces in the indirect layer; the thesis has 1"});
    visitor.enumeration("injection", injection,
                        {Light, kInjections,
                         "light paths from the lights, or a jittered reflective shadow map of each light, which knows "
                         "one bounce only"});
    visitor.field("rays_per_photon", rays_per_photon,
                  {Light, "rays", 1, 1024, "splats of a photon, in stratified directions"});
    visitor.flag("stratify", stratify, {Stratification, "splat the photons of a voxel as few"});
    visitor.field("grid_cells", grid_cells,
                  {Stratification, "cells", 1, 1024, "stratification: voxels along the longest side of the scene"});
    visitor.field("minimum_photons", minimum_photons,
                  {Stratification, "photons", 1, 1e6,
                   "stratification: a block of 2x2x2 cells of which one holds fewer, but some, becomes one cell; from "
                   "2 on a lone photon joins all about it, and the noise is that of few splats"});
    visitor.field("splats_per_cell", splats_per_cell,
                  {Stratification, "splats", 1, 1024, "stratification: splats of a cell"});
    visitor.enumeration("representative", representative,
                        {Stratification, kRepresentatives,
                         "stratification: which photons splat for their cell; the last two are biased, as in the "
                         "thesis"});
    visitor.field("splat_size", splat_size_m,
                  {Light, "m", 1e-9, 1e9,
                   "side of a splat; its radius is half of that; of beams beside connections a quarter, with "
                   "adaptive_size at most half"});
    visitor.field(
        "splat_size_relative", splat_size_relative,
        {Light, "", 1e-9, 1e3, "the same, over the radius of the scene's bounding sphere; 0.2 when neither is given"});
    visitor.flag("adaptive_size", adaptive_size,
                 {Splats,
                  "connect: splats are smaller where light is dense and larger where it is rare, by a pilot's photons; "
                  "exact in the mean like any size. Beams hold few photons, and are no wider than what casts them"});
    visitor.enumeration("filter", filter, {Splats, kFilters, "weight of a splat across its axis, radial"});
    visitor.enumeration("weighting", weighting,
                        {Splats, kWeightings, "normalised: the thesis' colour over weight; radiometric: watts"});
    visitor.enumeration("estimator", estimator,
                        {Splats, kEstimators,
                         "radiometric: photons connect with the points their rays pass by (no kernel bias), or light "
                         "along their rays (consistent with shrink)"});
    visitor.field(
        "step_back", step_back_m,
        {Splats, "m", 0, 1e9, "a beam begins that far before the hit of its ray; ten splat radii when not given"});
    visitor.field("splat_depth", splat_depth_m,
                  {Splats, "m", 1e-9, 1e9, "how far a beam lights from there; step_back and ten radii when not given"});
    visitor.field("shadow_resolution", shadow_resolution,
                  {Splats, "texels", 4, 64, "beams: depth map texels along each side of a splat"});
    visitor.flag("visibility", visibility,
                 {Light, "shadow rays of connections, depth maps of beams; without, light leaks"});
    visitor.flag(
        "shrink", shrink,
        {Splats,
         "radiometric beams become narrower from pass to pass, so that their blur vanishes; connections have none"});
    visitor.field("alpha", alpha,
                  {Splats, "", 0.01, 0.99, "share of the noise kept: shrinking is faster the lower it is"});
    visitor.flag("repay", repay,
                 {NoiseAndBias,
                  "connect: what the clamp within a splat's radius of the photon takes is made up for by one short ray "
                  "a visible point"});
    visitor.enumeration("blur", blur, {Filter, kBlurs, "Gaussian blur of each pass's indirect layer, pixels across"});
    visitor.flag("blur_edges", blur_edges, {Filter, "the blur stops where normal or depth change"});
    visitor.field(
        "ambient", ambient,
        {Filter, "W m^-2 sr^-1", 0, 1e9, "radiance from everywhere for visible points that no splat reached"});
    visitor.field(
        "indirect_exposure", indirect_exposure,
        {Filter, "", 0, 1e9, "factor on the indirect layer; of normalised weighting, whose scale is arbitrary"});
    visitor.field("glossy_threshold", glossy_threshold,
                  {NoiseAndBias, "", 0, 1, "eye paths: lobes with GGX alpha below it are followed, not splatted on"});
    visitor.field("connect_threshold", connect_threshold,
                  {NoiseAndBias, "", 0, 1,
                   "photons: lobes with GGX alpha below it light along their direction, not by connection"});
    visit_sampler(visitor, sampler);
    temporal.visit(visitor);
}

}  // namespace photond
