#pragma once
#include <memory>

#include "renderer/frame/device_method.h"
#include "renderer/frame/follows_frames.h"
#include "renderer/methods/radiance_cache/aged_cells.h"
#include "renderer/methods/radiance_cache/params.h"

namespace photond {

/// RadianceCache on a device: the same cells, filled and asked by the same rules. Its paths are whole ones, with all
/// lobes of the first surface, and there are `gather_rays` of them a pixel, where the CPU gathers so many rays from one
/// first surface; the numbers are others.
class RadianceCacheGpu final : public FollowsFrames<DeviceMethod, CellsBetweenFrames> {
public:
    static constexpr const char* kName = "radiance_cache";
    using Params = RadianceCacheParams;

    explicit RadianceCacheGpu(const RadianceCacheParams& params);
    ~RadianceCacheGpu() override;
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const RadianceCacheParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take, to a factor of two.
    static uint64_t estimate_device_bytes(const RadianceCacheParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

private:
    DeviceFrame& frame() override;

    struct State;  // radiance_cache_gpu.cpp

    const RadianceCacheParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
