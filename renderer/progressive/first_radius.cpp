#include "renderer/progressive/first_radius.h"

#include <algorithm>
#include <cmath>

namespace photond {

namespace {

constexpr uint32_t kDoublings = 5;  // from the smallest disc to the largest
constexpr double kCurved = 3;       // standard deviations past which curvature is more than chance

}  // namespace

std::optional<float> first_radius_at(const RadiusPlace& place, const PhotonMap& pilot, double pilot_passes,
                                     const EstimateSettings& estimate, Neighbours& scratch) {
    pilot.find(place.surface.position, scratch);
    const float largest_m = scratch.radius_m;
    std::optional<float> first_m;
    for (uint32_t doubling = 0; doubling <= kDoublings; ++doubling) {
        const float radius_m = largest_m * std::exp2(-0.5f * static_cast<float>(kDoublings - doubling));
        DiscMoments moments;
        estimate_radiance(pilot, estimate, place.surface, place.bsdf, place.wo, place.most_scatterings, scratch,
                          {.radius_m = radius_m, .moments = &moments});
        if (!(moments.w_sq > 0)) continue;
        const double z_sq = 3 * moments.w_t * moments.w_t / moments.w_sq;
        const double share = std::pow(pilot_passes / (18 * std::max(z_sq - 1, 1.0)), 1.0 / 6);
        first_m = static_cast<float>(double{radius_m} * share);
        if (z_sq > kCurved * kCurved) break;
    }
    return first_m;
}

double over_schedule(double alpha) { return std::sqrt(std::tgamma(1 + alpha)); }

}  // namespace photond
