#pragma once
// What the rows of the progressive photon mapping methods have in common. Only a room's row.cpp needs this.

#include "renderer/frame/method_row.h"
#include "renderer/gathering/photon_gathering.h"
#include "renderer/progressive/progressive_params.h"

namespace photond {

inline PathsLeftOut left_out_by_progressive_photons(const ProgressiveParams& params, const Needs& needs) {
    return left_out_by_photons(bounces_of_scatterings(params.max_scatterings()), params.glossy_threshold, needs);
}

/// `Gpu`: void where there is none.
template <class Cpu, class Gpu>
MethodInfo progressive_row() {
    MethodInfo info = row_of_classes<Cpu, Gpu>();
    info.family = "photon mapping";
    info.left_out = left_out_of<ProgressiveParams, left_out_by_progressive_photons>;
    info.layers.add(Layer::PhotonCount);
    info.layers.add(Layer::Radius);
    info.layers.add(Layer::BiasEstimate);
    info.bias_falls_with.emplace();
    info.limits = limits_of_density_estimates();
    info.limits.push_back({{}, "sphere", "the density estimate takes a curved surface for a flat one"});
    info.passes_stand_alone =
        +[](const MethodParams& params) { return dynamic_cast<const ProgressiveParams&>(params).passes_stand_alone(); };
    // Not an artefact, but on the disk all the same: the state beside the film, and once more while it is saved again.
    info.estimate_artefact_bytes = +[](const MethodParams& params, const Workload& workload) {
        const auto& of_cpu = dynamic_cast<const typename Cpu::Params&>(params);
        return of_cpu.passes_stand_alone() ? 0 : 2 * Cpu::estimate_state_bytes(of_cpu, workload);
    };
    info.mergeable = info.passes_stand_alone(*info.make_params());
    return info;
}

}  // namespace photond
