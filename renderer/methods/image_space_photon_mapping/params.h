#pragma once
// The parameters of image-space photon mapping: each is a field here, and a line of visit().

#include <optional>

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/gbuffer/upsampling.h"
#include "renderer/photons/disc_coverage.h"
#include "renderer/photons/kernel.h"
#include "renderer/photons/photon_params.h"
#include "renderer/photons/radius_schedule.h"
#include "renderer/transport/sobol.h"

namespace photond {

/// What a photon lights.
enum class PhotonFootprint : uint8_t {
    Quad,    // what lies near its surface's plane
    Volume,  // what lies within a flattened ball
    Auto,    // both together: of either the greater share
};

/// How the pixels are found that a photon lights.
enum class PhotonScatter : uint8_t {
    Tiles,   // each block of pixels goes through the photons that may reach it
    Raster,  // each photon is drawn over the pixels
};

/// Where photons are traced.
enum class PhotonTrace : uint8_t {
    Gpu,
    Cpu,  // on the host's cores, while the device draws those of the pass before
};

/// How much is seen of a light that is not a point.
enum class SoftShadow : uint8_t {
    Gather,       // by its middle; its shadow is blurred by how far off what casts it is
    FixedRadius,  // the same, as if that were half way to the light
    Rays,         // a ray to a point of it, another one in each pass
    None,         // by its middle alone: hard shadows
};

struct ImageSpacePhotonMappingParams final : MethodParams {
    TemporalParams temporal;
    uint32_t photons = 50'000;
    std::optional<uint32_t> caustic_photons;
    PhotonTrace trace = PhotonTrace::Gpu;
    std::optional<uint32_t> bounce_map_texels;
    std::optional<uint32_t> bounces;
    PhotonFootprint footprint = PhotonFootprint::Auto;
    float volume_height = 0.5f;
    PhotonScatter scatter = PhotonScatter::Tiles;
    DiscBoundary boundary = DiscBoundary::Clip;  // of quads
    std::optional<float> radius_m;
    std::optional<float> radius_relative;
    float caustic_radius_share = 0.35f;
    bool shrink = true;
    uint32_t subsampling = 1;
    Upsampling upsampling = Upsampling::Geometry;
    SoftShadow soft_shadow = SoftShadow::Rays;
    uint32_t shadow_search_samples = 4;
    uint32_t shadow_blur_samples = 5;
    bool one_pass = true;
    float alpha = static_cast<float>(kRadiusAlpha);
    KernelShape kernel = KernelShape::Epanechnikov;
    float cone_k = 1.1f;
    bool projection_maps = true;
    float glossy_threshold = 0.05f;
    SamplerKind sampler = SamplerKind::Sobol;

    void visit(ParamVisitor& visitor) override;
    void check() const override;

    bool traces_on_host() const { return trace == PhotonTrace::Cpu; }
    /// Whether footprints are cut where their surface ends: those that keep to it.
    bool clips() const { return boundary == DiscBoundary::Clip && footprint != PhotonFootprint::Volume; }
    /// Whether shadows are those of lights' middles.
    bool shadows_by_centres() const { return soft_shadow != SoftShadow::Rays; }
    /// Greatest number of scatterings of a photon.
    uint32_t photon_scatterings() const { return bounces.value_or(UINT32_MAX); }
    /// Greatest number of scattering vertices of a path: n vertices make n - 1 bounces (conventions.md).
    uint32_t max_scatterings() const { return bounces && *bounces < UINT32_MAX ? *bounces + 1 : UINT32_MAX; }
    /// Of a pass's photons, in a scene whose bounding sphere has that radius [m].
    float radius_of_pass_m(uint32_t pass, float scene_radius_m) const;
};

}  // namespace photond
