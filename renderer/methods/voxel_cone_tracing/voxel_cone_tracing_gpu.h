#pragma once
#include <memory>

#include "renderer/frame/device_method.h"
#include "renderer/methods/voxel_cone_tracing/params.h"

namespace photond {

/// Voxel cone tracing, a baseline on GPUs [Crassin et al. 2011; svo-many-lights, 2.3.3]: virtual point lights of all
/// bounces (many_lights/vpl_tracer_gpu.h) light the voxels of an octree, whose light and opacity are filtered up to
/// cells of two, four, ... voxels, seen from six sides; each point asks five cones about its normal and one about the
/// mirrored direction, as wide as the gloss is.
///
/// Departures from the paper. Where a cell lies a table says, so that cones do not walk down the tree; cells are not
/// kept twice at their neighbours' for the sake of texture units. How much of a voxel is covered, by axis, is asked of
/// rays, so that a voxel that a surface only touches does not hide another. Cells that the plane of the point's surface
/// crosses are its own and do not count, where the paper starts farther off. A step looks at one of the sixteen cells
/// that it lies between, by chance (`cells`), and cones are drawn by the cosine (`directions`): what the passes' mean
/// has less of is error. Lights bring all bounces; in the paper cones gather a second one.
///
/// Its bias, which does not fall with the passes: cones see cells, whose mean is not what a ray sees, and cells about a
/// wall have what is before it and behind it; what lies in cells that a point's own plane crosses it does not see.
///
/// [Crassin et al. 2011] Interactive Indirect Illumination Using Voxel Cone Tracing. Computer Graphics Forum 30(7).
class VoxelConeTracingGpu final : public DeviceMethod {
public:
    static constexpr const char* kName = "voxel_cone_tracing";
    using Params = VoxelConeTracingParams;

    explicit VoxelConeTracingGpu(const VoxelConeTracingParams& params);
    ~VoxelConeTracingGpu() override;
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const VoxelConeTracingParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take, to a factor of two.
    static uint64_t estimate_device_bytes(const VoxelConeTracingParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

private:
    DeviceFrame& frame() override;

    struct State;  // voxel_cone_tracing_gpu.cpp

    const VoxelConeTracingParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
