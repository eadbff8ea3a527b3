#pragma once
#include <memory>

#include "renderer/frame/device_method.h"
#include "renderer/frame/follows_frames.h"
#include "renderer/methods/visibility_filtering/kept_lists.h"
#include "renderer/methods/visibility_filtering/params.h"

namespace photond {

/// Visibility filtering, on GPUs: one bounce of light from point proxies (point_proxies_gpu.h). Which of their voxels a
/// pixel sees, some pixels find out by sparse rays; those about them on the same surface share what they found
/// (visibility_lists_gpu.h). Near voxels then light proxy by proxy, far ones by spherical harmonics of order 1.
///
/// Biased: how much of a voxel is seen is that of a window of pixels, as far as few rays tell (with lists of bits or
/// indices wholly or not at all), discs leave holes and hide what is near them, far voxels are smooth, and light of
/// proxies nearer than the radius of their share is softened. With `visibility` rays the first two are gone, and with
/// `shrink` the others fall from pass to pass. What narrow lobes of lit surfaces reflect is not in it, and rough lobes'
/// light leaves them as if they were Lambert.
///
/// With `kept_lists` points take over the lists of frames before (kept_lists.h), which were made a little beside them.
///
/// [Chen et al. 2014] Visibility Filtering for Producing Indirect Illumination. Eurographics, short papers. Departures,
/// by default: lists count rays; a light sample and its ray light each proxy, not one light's depth map; weights that
/// sum to 1.
class VisibilityFilteringGpu final : public FollowsFrames<DeviceMethod, ListsBetweenFrames> {
public:
    static constexpr const char* kName = "visibility_filtering";
    using Params = VisibilityFilteringParams;

    explicit VisibilityFilteringGpu(const VisibilityFilteringParams& params);
    ~VisibilityFilteringGpu() override;
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const VisibilityFilteringParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take, to a factor of two.
    static uint64_t estimate_device_bytes(const VisibilityFilteringParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

private:
    DeviceFrame& frame() override;

    struct State;  // visibility_filtering_gpu.cpp

    const VisibilityFilteringParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
