#pragma once
#include "renderer/frame/device_method.h"
#include "renderer/frame/follows_frames.h"
#include "renderer/methods/svo_many_lights/svo_many_lights.h"

namespace photond {

/// SvoManyLights on a GPU: the same points, lights and random numbers, so that images differ from the CPU's by
/// rounding. Sums are taken in one order: the same image from run to run on one device.
///
/// A pass is one chain of submits, read back at its end: the lights' maps and the lights (stages `rsm`,
/// `vpl_generation`, with depth maps `shadow_maps`), the walk from the eye (`direct`: the G-buffer and its split are
/// written on the way, and are no stages of their own), light from lights to points (`indirect`), `repay`, `filter` and
/// `merge`. How many lights there are stays on the device.
class SvoManyLightsGpu final : public FollowsFrames<DeviceMethod, VplsBetweenFrames> {
public:
    using Params = SvoManyLightsParams;

    explicit SvoManyLightsGpu(const SvoManyLightsParams& params);
    ~SvoManyLightsGpu() override;
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const SvoManyLightsParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take, to a factor of two.
    static uint64_t estimate_device_bytes(const SvoManyLightsParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

private:
    DeviceFrame& frame() override;

    struct State;  // svo_many_lights_gpu.cpp

    const SvoManyLightsParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
