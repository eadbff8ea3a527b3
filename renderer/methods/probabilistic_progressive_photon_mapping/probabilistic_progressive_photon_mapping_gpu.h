#pragma once
#include "renderer/methods/probabilistic_progressive_photon_mapping/probabilistic_progressive_photon_mapping.h"
#include "renderer/progressive/progressive_mapping_gpu.h"

namespace photond {

/// ProbabilisticProgressivePhotonMapping on a GPU, as progressive/progressive_mapping_gpu.h says.
class ProbabilisticProgressivePhotonMappingGpu final : public ProgressiveMappingGpu {
public:
    using Params = ProbabilisticProgressivePhotonMappingParams;

    explicit ProbabilisticProgressivePhotonMappingGpu(const Params& params)
        : ProgressiveMappingGpu(std::make_unique<Params>(params)) {}
    static uint64_t estimate_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMappingGpu::estimate_bytes(params, workload);
    }
    static uint64_t estimate_device_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMappingGpu::estimate_device_bytes(params, workload);
    }
};

}  // namespace photond
