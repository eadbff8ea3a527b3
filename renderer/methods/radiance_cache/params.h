#pragma once
// The parameters of the radiance cache: each is a field here, and a line of visit().

#include <optional>
#include <string_view>
#include <vector>

#include "protocol/param_info.h"
#include "renderer/frame/common_params.h"
#include "renderer/photons/radius_schedule.h"
#include "renderer/transport/sobol.h"

namespace photond {

/// Where the paths that fill the cache end: in what it knows already, or by roulette alone.
enum class SecondBounces : uint8_t { Paths, Cache };

struct RadianceCacheParams final : MethodParams {
    TemporalParams temporal;
    std::optional<uint32_t> indirect_bounces;
    uint32_t gather_rays = 4;
    float training = 0.25f;
    SecondBounces second_bounces = SecondBounces::Paths;
    float cell_size = 0.1f;  // over the distance to the eye
    uint32_t cells = 1u << 18;
    uint32_t direction_bins = 3;
    uint32_t least_samples = 8;
    float glossy_threshold = 0.05f;
    bool shrink = true;
    float alpha = static_cast<float>(kRadiusAlpha);
    SamplerKind sampler = SamplerKind::Sobol;
    bool aged = false;
    uint32_t cache_age = 8;  // frames that a cell's samples are of, at most, as they count

    void visit(ParamVisitor& visitor) override;
    /// Greatest number of scattering vertices of a path: n vertices make n - 1 bounces (conventions.md).
    uint32_t max_scatterings() const { return indirect_bounces ? *indirect_bounces + 1 : UINT32_MAX; }
    /// What a frame leaves to the next beside its indirect light.
    std::vector<std::string_view> left_beside_light() const {
        return aged ? std::vector<std::string_view>{"cells of radiance"} : std::vector<std::string_view>{};
    }
    /// Of cells, over those of the first pass.
    float share_of_pass(uint32_t pass) const { return shrink ? radius_share(pass, double{alpha}) : 1; }
};

}  // namespace photond
