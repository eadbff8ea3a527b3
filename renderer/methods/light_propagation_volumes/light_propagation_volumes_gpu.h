#pragma once
#include <memory>

#include "renderer/frame/device_method.h"
#include "renderer/methods/light_propagation_volumes/params.h"

namespace photond {

/// Light propagation volumes, a baseline on GPUs [Kaplanyan and Dachsbacher 2010; svo-many-lights, 2.3.1]: virtual
/// point lights of all bounces (many_lights/vpl_tracer_gpu.h) start in a grid of cells, whose light of all directions
/// is known by spherical harmonics of order 1; step after step it goes on to neighbouring cells, and what has passed
/// through the cells before a surface lights it. A few cells' widths are how well it knows where light is, and a third
/// of all directions where it comes from: shadows of bounced light are soft, gloss is blurred, and light leaks about
/// edges.
///
/// Departures from the paper. What stands between cells is asked of rays through each face (volume_faces.comp), not
/// gathered from depth maps as surfels of order 1: a wall thinner than a cell stops light from either side, and cells
/// beside it are not dimmed. Lights start in cells that they see, and points beside walls take light from cells that
/// they see, so that none passes a closed surface. Where a step's harmonics are less than nothing they are cut off and
/// the rest is scaled, so that light neither grows nor dwindles. Cells behind a surface do not light it, where the
/// paper dims by the gradient. What enters a finer cascade comes from the coarser one, at its first step. Radiance is
/// what passes through a cell over the area that it shows. Further bounces are light paths' and not the volume's.
///
/// Left out: light that comes to a narrow lobe of a visible surface has the volume's directions, not the lobe's. Its
/// bias does not fall with the passes.
///
/// [Kaplanyan and Dachsbacher 2010] Cascaded Light Propagation Volumes for Real-Time Indirect Illumination. I3D.
class LightPropagationVolumesGpu final : public DeviceMethod {
public:
    static constexpr const char* kName = "light_propagation_volumes";
    using Params = LightPropagationVolumesParams;

    explicit LightPropagationVolumesGpu(const LightPropagationVolumesParams& params);
    ~LightPropagationVolumesGpu() override;
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const LightPropagationVolumesParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take, to a factor of two.
    static uint64_t estimate_device_bytes(const LightPropagationVolumesParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

private:
    DeviceFrame& frame() override;

    struct State;  // light_propagation_volumes_gpu.cpp

    const LightPropagationVolumesParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
