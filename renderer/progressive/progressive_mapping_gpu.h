#pragma once
#include <memory>

#include "renderer/frame/device_method.h"
#include "renderer/progressive/progressive_params.h"

namespace photond {

/// ProgressiveMapping on a GPU, with hit points that are new in each pass: the same photons, eye paths and discs with
/// the same numbers, so that images differ from the CPU's by rounding alone, and a film goes on from one device to the
/// other (a path or a test that rounding sends elsewhere is a sample of its own right). Photons are sorted into one
/// order before they are summed: the same image from run to run on one device.
///
/// The rules `global` and `trained` are the host's (global_radii.h, trained_radii.h): it traces their pilots. What
/// points count stays on the device (point_radii_gpu.h), and is read back with each pass's image, for the film. Stage
/// `gather` is what paths from the eye take.
class ProgressiveMappingGpu : public DeviceMethod {
public:
    explicit ProgressiveMappingGpu(std::unique_ptr<const ProgressiveParams> params);
    ~ProgressiveMappingGpu() override;

    void go_on_from(const std::string& state) override;
    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    PassImage* end_pass() override;
    std::string state() const override;

protected:
    /// Bytes of the host's memory, and of the device's, that begin() will take, at most.
    static uint64_t estimate_bytes(const ProgressiveParams& params, const Workload& workload);
    static uint64_t estimate_device_bytes(const ProgressiveParams& params, const Workload& workload);

private:
    DeviceFrame& frame() override;

    struct State;  // progressive_mapping_gpu.cpp

    const std::unique_ptr<const ProgressiveParams> params_;
    std::string state_before_;
    std::unique_ptr<State> state_;
};

/// The twin of a method of the CPU's.
template <class Cpu>
class ProgressiveTwinGpu final : public ProgressiveMappingGpu {
public:
    using Params = typename Cpu::Params;

    explicit ProgressiveTwinGpu(const Params& params) : ProgressiveMappingGpu(std::make_unique<Params>(params)) {}
    static uint64_t estimate_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMappingGpu::estimate_bytes(params, workload);
    }
    static uint64_t estimate_device_bytes(const Params& params, const Workload& workload) {
        return ProgressiveMappingGpu::estimate_device_bytes(params, workload);
    }
};

}  // namespace photond
