#pragma once
// The parameters of visibility filtering: each is a field here, and a line of visit().

#include <optional>
#include <string_view>
#include <vector>

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/gbuffer/upsampling.h"
#include "renderer/photons/radius_schedule.h"
#include "renderer/transport/sobol.h"

namespace photond {

/// Who says which voxels a point of the image sees.
enum class ProxyVisibility : uint8_t {
    Discs,  // sparse rays, which the proxies' discs stop
    Svo,    // the same rays, stopped by a voxel octree of the triangles
    Rays,   // a shadow ray to every voxel that has light
};

/// What tells whether a punctual light reaches a proxy.
enum class ProxyShadows : uint8_t { Rays, DepthMaps };

/// What a list tells of its voxels.
enum class ListKind : uint8_t {
    Counts,   // how many rays have met each: it counts by as much of it as they say is seen
    Bits,     // whether any has: it counts wholly
    Indices,  // the same, as numbers of voxels, and each list lights by itself
};

/// What a voxel's contribution is divided by where four lists are mixed.
enum class ListNormalisation : uint8_t {
    Weights,  // the sum of the lists' weights
    Paper,    // the number of the lists
};

/// How narrow lobes look at voxels.
enum class ProxySpecular : uint8_t {
    Ggx,    // by the BSDF
    Paper,  // by a Gaussian about the mirrored direction, whatever the number of proxies in it
};

struct VisibilityFilteringParams final : MethodParams {
    TemporalParams temporal;
    uint32_t proxies = 24'000;
    uint32_t voxels = 8;
    uint32_t bounces = 1;
    ProxyShadows proxy_shadows = ProxyShadows::Rays;
    uint32_t depth_map_resolution = 1024;
    ProxyVisibility visibility = ProxyVisibility::Discs;
    ListKind lists = ListKind::Counts;
    uint32_t rays = 64;
    bool world_rays = false;
    float most_seen = 4;
    float disc_scale = 2;
    uint32_t voxel_resolution = 128;
    uint32_t march_subsampling = 4;
    uint32_t filter_side = 7;
    float filter_normal = 0.9f;
    float filter_distance = 0.02f;
    ListNormalisation normalisation = ListNormalisation::Weights;
    ProxySpecular specular = ProxySpecular::Ggx;
    float near_voxels = 1.5f;
    bool shrink = false;
    float alpha = static_cast<float>(kRadiusAlpha);
    uint32_t subsampling = 2;
    Upsampling upsampling = Upsampling::Geometry;
    float glossy_threshold = 0.05f;
    SamplerKind sampler = SamplerKind::Sobol;
    uint32_t kept_lists = 0;  // of frames before, that a point takes over at most

    void visit(ParamVisitor& visitor) override;
    void check() const override;

    /// What a frame leaves to the next beside its indirect light.
    std::vector<std::string_view> left_beside_light() const {
        return kept_lists > 0 ? std::vector<std::string_view>{"lists of voxels"} : std::vector<std::string_view>{};
    }
    bool asks_rays() const { return visibility == ProxyVisibility::Rays; }
    /// Greatest number of scattering vertices of a path: n vertices make n - 1 bounces (conventions.md).
    uint32_t max_scatterings() const { return bounces + 1; }
    /// Of a pass, over those of the first: voxels, what is near, and the proxies' softening.
    float share_of_pass(uint32_t pass) const { return shrink ? radius_share(pass, double{alpha}) : 1; }
    /// Along the longest side of the scene's box.
    uint32_t voxels_of_pass(uint32_t pass) const;
};

}  // namespace photond
