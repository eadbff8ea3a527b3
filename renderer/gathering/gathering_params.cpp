#include "renderer/gathering/gathering_params.h"

namespace photond {

namespace {

// Over the radius of the scene's bounding sphere. A nearest search hardly ever comes to its limit where there is light:
// it bounds the time where there is next to none (0.1 instead makes the `interior`'s final gathering 1.2 times as slow,
// with clipped discs 1.6 times, for the same mean). The fixed radius is a compromise of noise and blur for some 1e5
// photons.
constexpr float kLimitRelative = 0.05f;
constexpr float kRadiusRelative = 0.03f;

constexpr uint32_t kGatherRaysToLightSample = 4;

// Of a pass, at most: so that it takes 2 s at 512x512, four rays a pixel. With fewer rays a pixel photons are traced
// more often for as many rays: beside those of a large image they cost little (3 % at 512x512), beside those of a small
// one much (at 160x120 half of them take up to 1.6 times as long to the same error). Hence no fewer where the image is
// small.
constexpr uint64_t kGatherRaysOfPass = 1 << 20;
constexpr uint64_t kMostGatherRays = 8;

float given_radius_m(const GatheringParams& params, float relative, float scene_radius_m) {
    if (params.radius_m) return *params.radius_m;
    // A scene without extent holds nothing to be found, but a search wants a radius.
    return std::max(params.radius_relative.value_or(relative) * scene_radius_m, 1e-20f);
}

}  // namespace

void GatheringParams::check() const { require_one_radius(radius_m, radius_relative); }

Splits GatheringParams::splits(uint64_t pixels) const {
    const uint64_t fitting =
        std::clamp<uint64_t>(kGatherRaysOfPass / std::max<uint64_t>(pixels, 1), 1, kMostGatherRays);
    const uint32_t rays = final_gather() ? gather_rays.value_or(static_cast<uint32_t>(fitting)) : 0;
    return {light_samples.value_or(std::max(rays / kGatherRaysToLightSample, 1u)), rays};
}

float GatheringParams::search_radius_m(float scene_radius_m) const {
    const float relative = search_kind() == PhotonSearch::Kind::Nearest ? kLimitRelative : kRadiusRelative;
    return given_radius_m(*this, relative, scene_radius_m);
}

float GatheringParams::shadow_radius_m(float scene_radius_m) const {
    return given_radius_m(*this, kRadiusRelative, scene_radius_m);
}

}  // namespace photond
