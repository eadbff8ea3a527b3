#include "renderer/progressive/global_radii.h"

#include "renderer/photons/pilot_radius.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr uint32_t kPilotNearest = 8;              // photons among which the pilot's density is measured
constexpr PerMap<double> kBrightShare{0.5, 0.25};  // of the power is where a map is denser: filaments are narrow

}  // namespace

GlobalRadii::GlobalRadii(const DiscRadiiInputs& inputs, Stats& stats) : alpha_(double{inputs.params.alpha}) {
    const float scene_radius_m = inputs.context.scene.bounds.radius();
    const RadiusLimits limits(scene_radius_m);
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        float& first_m = first_m_[index_of(kind)];
        if (const auto given_m = inputs.params.first_radius_m(scene_radius_m)) {
            first_m = *given_m;
            continue;
        }
        first_m = limits.most_m;
        std::vector<Photon> pilot = inputs.photons.trace_pilot(kind, 1, stats);
        if (pilot.empty()) continue;
        const StageTimer timer(stats, "photon_map_build");
        const float wanted_m =
            radius_of_pilot(PhotonMap(std::move(pilot), {PhotonSearch::Kind::Nearest, kPilotNearest, limits.most_m}),
                            {.photons_in_radius = double(inputs.params.nearest_photons),
                             .bright_share = kBrightShare[index_of(kind)],
                             .paths_over_pilot = 1});
        first_m = std::clamp(wanted_m, limits.least_m, limits.most_m);
    }
    begin_pass(0);
}

void GlobalRadii::begin_pass(uint32_t pass) {
    for (const PhotonMapKind kind : kPhotonMapKinds)
        pass_m_[index_of(kind)] = first_m_[index_of(kind)] * radius_share(pass, alpha_);
}

float GlobalRadii::radius_m(PhotonMapKind kind, const DiscPlace&, Neighbours&) { return pass_m_[index_of(kind)]; }

}  // namespace photond
