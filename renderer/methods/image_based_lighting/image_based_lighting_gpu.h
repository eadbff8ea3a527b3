#pragma once
#include "renderer/frame/device_method.h"
#include "renderer/methods/image_based_lighting/image_based_lighting.h"

namespace photond {

/// ImageBasedLighting on a GPU: the host's maps and the same walks with the same numbers, so that the image differs
/// from the CPU's by rounding alone. It is the same from run to run on one device.
class ImageBasedLightingGpu final : public DeviceMethod {
public:
    using Params = ImageBasedLightingParams;

    explicit ImageBasedLightingGpu(const ImageBasedLightingParams& params);
    ~ImageBasedLightingGpu() override;
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const ImageBasedLightingParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take.
    static uint64_t estimate_device_bytes(const ImageBasedLightingParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

private:
    DeviceFrame& frame() override;

    struct State;  // image_based_lighting_gpu.cpp

    const ImageBasedLightingParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
