#pragma once
#include <memory>

#include "renderer/bidirectional/bidirectional_params.h"
#include "renderer/frame/device_method.h"

namespace photond {

/// BidirectionalMethod on a GPU: the same light and eye paths with the same numbers, joined in the same ways, so that
/// images differ from the CPU's by rounding alone (a path that rounding sends elsewhere is a sample of its own right;
/// so are the connections of a pass whose light paths left one vertex more or less). The pilots are the host's.
/// Vertices are sorted into one order before they are joined or summed: the same image from run to run on one device.
class BidirectionalMethodGpu : public DeviceMethod {
public:
    explicit BidirectionalMethodGpu(std::unique_ptr<const BidirectionalParams> params);
    ~BidirectionalMethodGpu() override;

    /// Throws Error where parameters ask for what a GPU does not do.
    static void check_gpu(const BidirectionalParams& params);
    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

protected:
    /// Bytes of the host's memory, and of the device's, that begin() will take, at most.
    static uint64_t estimate_bytes(const BidirectionalParams& params, const Workload& workload);
    static uint64_t estimate_device_bytes(const BidirectionalParams& params, const Workload& workload);

private:
    DeviceFrame& frame() override;

    struct State;  // bidirectional_method_gpu.cpp

    const std::unique_ptr<const BidirectionalParams> params_;
    std::unique_ptr<State> state_;
};

/// The twin of a method of the CPU's.
template <class Cpu>
class BidirectionalTwinGpu final : public BidirectionalMethodGpu {
public:
    using Params = typename Cpu::Params;

    explicit BidirectionalTwinGpu(const Params& params)
        : BidirectionalMethodGpu(std::make_unique<Params>(on_gpu(params))) {}
    static uint64_t estimate_bytes(const Params& params, const Workload& workload) {
        return BidirectionalMethodGpu::estimate_bytes(on_gpu(params), workload);
    }
    static uint64_t estimate_device_bytes(const Params& params, const Workload& workload) {
        return BidirectionalMethodGpu::estimate_device_bytes(on_gpu(params), workload);
    }

private:
    /// With what is automatic as a GPU has it: pilots are to judge what is rendered.
    static Params on_gpu(Params params) {
        if constexpr (requires { params.merging_params; })
            if (params.merging_params.weights == MergeWeights::Automatic)
                params.merging_params.weights = MergeWeights::Recursive;
        return params;
    }
};

}  // namespace photond
