#pragma once
#include "renderer/methods/stochastic_progressive_photon_mapping/stochastic_progressive_photon_mapping.h"
#include "renderer/progressive/progressive_mapping_gpu.h"

namespace photond {

/// StochasticProgressivePhotonMapping on a GPU, as progressive/progressive_mapping_gpu.h says.
class StochasticProgressivePhotonMappingGpu final : public ProgressiveMappingGpu {
public:
    using Params = StochasticProgressivePhotonMappingParams;

    explicit StochasticProgressivePhotonMappingGpu(const Params& params)
        : ProgressiveMappingGpu(std::make_unique<Params>(params)) {}
    static uint64_t estimate_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMappingGpu::estimate_bytes(params, workload);
    }
    static uint64_t estimate_device_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMappingGpu::estimate_device_bytes(params, workload);
    }
};

}  // namespace photond
