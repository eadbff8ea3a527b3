#pragma once
// Beams drawn as volumes over the visible points, beside splat_light.comp, which goes through them cluster by cluster:
// the thesis' way of splatting (3.4).

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/frame/render_context.h"
#include "renderer/splats/added_images.h"

namespace photond {

/// Each splat's frustum is drawn into float images that blend by adding, in the order of the splats: the same bits
/// every time. A pixel has one visible point, seen through it: so no surface may be followed to others, and the camera
/// is a pinhole. In the accounts as "splat_volumes", 48 bytes a pixel.
///
/// Measured on lavapipe, cornell-box at 320x240, three passes of 2,600 splats, seconds of volumes and of clusters:
/// splats of relative size 0.05 0.8 and 1.2, 0.2 (the default) 2.5 to 3.1 and 2.2 to 2.5, 0.6 5.6 to 7.8 and 3.3
/// to 3.5. A fragment costs more than a point of a cluster, but no cluster is tested in vain. Clusters, which are right
/// in all scenes, are the default.
class SplatVolumes {
public:
    /// `specialization`: that of splat_light.comp.
    SplatVolumes(const gpu::DeviceScene& scene, Size2 size, std::span<const gpu::Specialization> specialization);
    /// `needs`: of the scene. Where all splats are beams.
    static bool possible(const Needs& needs, const Camera& camera);

    /// What the visible points of a pass are: buffers of PhotonSplattingGpu.
    struct Points {
        gpu::Buffer &eye, &constants, &heads, &points, &sums, &counters;
    };
    /// Splats of a draw, so that cancelling is answered soon.
    uint32_t splats_at_once() const;
    /// Splats [first, end) of a batch. `clear`: the first of the pass.
    void record(gpu::CommandList& commands, const Points& points, gpu::Buffer& splats, gpu::Buffer& depth_maps,
                uint32_t first, uint32_t end, bool clear);
    /// After the pass's last: to the points' sums.
    void record_sums(gpu::CommandList& commands, const Points& points);

private:
    gpu::Device& device_;
    const uint32_t pixels_;
    AddedImages images_;  // light and splats, weight and contributions
    gpu::RasterPipeline draw_;
    gpu::ComputePipeline sum_;
};

}  // namespace photond
