#pragma once
#include <memory>

#include "renderer/frame/device_method.h"
#include "renderer/frame/follows_frames.h"
#include "renderer/many_lights/incremental_vpls.h"
#include "renderer/methods/reflective_shadow_maps/params.h"

namespace photond {

/// Reflective shadow maps, a baseline on GPUs: each texel of the lights' maps is a light that reaches every point, for
/// visibility is not asked. Too bright by what stands between; in an open scene right.
///
/// `flux`: `samples` texels chosen by their flux light all points of a pass, other ones in the next: without `clamp`
/// the mean over the passes is the transport of one bounce with nothing in its way.
///
/// `paper`: each point draws its samples about its own place in each light's map, at distances u `sample_radius` of the
/// map's side, u uniform, and weighs them by u^2 [Dachsbacher and Stamminger 2005, sec. 4.1]. Their weighted mean,
/// times the light's texels, is its light: the same as that of all texels where all bring the same, else not, as far
/// texels are asked seldom and none past the radius. Samples past the map's border are dropped. Each light has samples
/// in proportion to its texels, at least one by chance. A texel brings Phi / pi cos_o cos_x / max(B, d^2), Phi the flux
/// it reflects [W]: the paper has vectors that are not unit in both cosines, hence its d^4, and leaves out 1 / pi.
///
/// A point's place in a map is what the numbers would be that EmissionSampler sends a ray to it by
/// (photons/texel_map.h): the direction from a point light or a spot, the place on a directional light's disc; from an
/// area light, the direction from a triangle's middle: its map is of directions, from anywhere on it, and where it
/// emits to both sides, what lies on the point's side alone is asked. The environment's is of directions too, each from
/// a random place, so that no point is nearer to one texel than to another: points ask it all over. With `paper` what
/// is lit reflects as if it were Lambert; light that narrow lobes of it reflect is in neither. Not implemented:
/// interpolation between sparse pixels (sec. 4.2), further bounces.
///
/// [Dachsbacher and Stamminger 2005] Reflective Shadow Maps. I3D.
class ReflectiveShadowMapsGpu final : public FollowsFrames<DeviceMethod, VplsBetweenFrames> {
public:
    static constexpr const char* kName = "reflective_shadow_maps";
    using Params = ReflectiveShadowMapsParams;

    explicit ReflectiveShadowMapsGpu(const ReflectiveShadowMapsParams& params);
    ~ReflectiveShadowMapsGpu() override;
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const ReflectiveShadowMapsParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take, to a factor of two.
    static uint64_t estimate_device_bytes(const ReflectiveShadowMapsParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

private:
    DeviceFrame& frame() override;

    struct State;  // reflective_shadow_maps_gpu.cpp

    const ReflectiveShadowMapsParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
