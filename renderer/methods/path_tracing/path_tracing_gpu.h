#pragma once
#include "renderer/frame/device_method.h"
#include "renderer/methods/path_tracing/path_tracing.h"

namespace photond {

/// PathTracing on a GPU: the same paths with the same numbers, so that the image differs from the CPU's by rounding
/// alone (a path that rounding sends elsewhere is a sample of its own right). What a path brings is added to its
/// pixel in the path's own order, so the image is the same from run to run on one device.
class PathTracingGpu final : public DeviceMethod {
public:
    using Params = PathTracingParams;

    explicit PathTracingGpu(const PathTracingParams& params);
    ~PathTracingGpu() override;
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const PathTracingParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take.
    static uint64_t estimate_device_bytes(const PathTracingParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

private:
    DeviceFrame& frame() override;

    struct State;  // path_tracing_gpu.cpp

    const PathTracingParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
