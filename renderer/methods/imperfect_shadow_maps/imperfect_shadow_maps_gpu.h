#pragma once
#include <memory>

#include "renderer/frame/device_method.h"
#include "renderer/frame/follows_frames.h"
#include "renderer/many_lights/incremental_vpls.h"
#include "renderer/methods/imperfect_shadow_maps/params.h"

namespace photond {

/// Imperfect shadow maps, a baseline on GPUs: the lights, points and sums of svo_many_lights, where V is answered by a
/// small depth map of each light that points are drawn into instead of triangles (many_lights/imperfect_shadow_maps.h).
///
/// Fast where triangles are many, as its cost is that of the points. Not exact, ever: shadows of what is thinner than
/// the points are apart are lost or too wide, none is nearer to a light than that; maps are coarse; what the clamp
/// takes is not given back. Light that narrow lobes of the surfaces lit directly reflect is not in it. Not implemented:
/// further bounces, for which the paper has imperfect reflective shadow maps; moving points with geometry.
///
/// [Ritschel, Grosch, Kim, Seidel, Dachsbacher, Kautz 2008] Imperfect Shadow Maps for Efficient Computation of Indirect
/// Illumination. ACM TOG 27(5).
class ImperfectShadowMapsGpu final : public FollowsFrames<DeviceMethod, VplsBetweenFrames> {
public:
    static constexpr const char* kName = "imperfect_shadow_maps";
    using Params = ImperfectShadowMapsParams;

    explicit ImperfectShadowMapsGpu(const ImperfectShadowMapsParams& params);
    ~ImperfectShadowMapsGpu() override;
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const ImperfectShadowMapsParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take, to a factor of two.
    static uint64_t estimate_device_bytes(const ImperfectShadowMapsParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

private:
    DeviceFrame& frame() override;

    struct State;  // imperfect_shadow_maps_gpu.cpp

    const ImperfectShadowMapsParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
