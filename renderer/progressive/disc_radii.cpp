#include "renderer/progressive/disc_radii.h"

#include "renderer/progressive/global_radii.h"
#include "renderer/progressive/point_radii.h"
#include "renderer/progressive/trained_radii.h"

namespace photond {

namespace {

constexpr float kMostRelative = 0.05f;
constexpr float kLeastRelative = 1e-5f;

}  // namespace

RadiusLimits::RadiusLimits(float scene_radius_m)
    // A scene without extent holds nothing to be found, but a search wants a radius.
    : least_m(kLeastRelative * std::max(scene_radius_m, 1e-16f)),
      most_m(kMostRelative * std::max(scene_radius_m, 1e-16f)) {}

std::unique_ptr<DiscRadii> make_disc_radii(const DiscRadiiInputs& inputs, Stats& stats) {
    switch (inputs.params.radius_rule) {
        case RadiusRule::Global: return std::make_unique<GlobalRadii>(inputs, stats);
        case RadiusRule::Trained: return std::make_unique<TrainedRadii>(inputs, stats);
        case RadiusRule::Local:
        case RadiusRule::Tested: return make_point_radii(inputs, stats);
    }
    return nullptr;
}

DiscRadiiBytes disc_radii_bytes(const ProgressiveParams& params, uint32_t hit_point_sets, const Workload& workload) {
    switch (params.radius_rule) {
        case RadiusRule::Global: return {.kept = sizeof(GlobalRadii)};
        case RadiusRule::Trained: return TrainedRadii::bytes_for(params, workload);
        case RadiusRule::Local:
        case RadiusRule::Tested: return point_radii_bytes(params, hit_point_sets, workload);
    }
    return {};
}

}  // namespace photond
