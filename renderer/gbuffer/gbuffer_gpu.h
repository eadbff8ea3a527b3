#pragma once
// GBuffer (gbuffer.h) on a device: direct light and one visible point a pixel, written where the split layout has
// it, so that splitting costs nothing of its own.

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/frame/device_image.h"
#include "renderer/frame/render_context.h"
#include "renderer/gbuffer/centre_shadows_gpu.h"
#include "renderer/gbuffer/gbuffer_walk_shared.h"
#include "renderer/gbuffer/light_depth_maps_gpu.h"
#include "renderer/gbuffer/split_buffer.h"
#include "renderer/transport/sobol.h"

namespace photond {

struct GBufferWalk {
    uint32_t split_side = 1;
    uint32_t max_scatterings = 2;    // EyeScene::max_scatterings
    float glossy_threshold = 0.05f;  // WalkSettings'
    SamplerKind sampler = SamplerKind::Sobol;
};

/// What tells of shadows; null: rays do. One at most.
struct GBufferShadows {
    LightDepthMapsGpu* depth_maps = nullptr;  // of punctual lights
    CentreShadowsGpu* centres = nullptr;      // takes the light of first surfaces, which does not go to the image
};

class GBufferGpu {
public:
    /// Borrows all; of the image the walk writes direct light, emitted light and first hits.
    GBufferGpu(const gpu::DeviceScene& scene, const View& view, uint64_t seed, const GBufferWalk& walk,
               DeviceImage& image, const GBufferShadows& shadows = {});
    static uint64_t device_bytes(Size2 size, uint32_t split_side, const Needs& needs);

    /// A pass is recorded in that many pieces, 0 ..., each short enough for one submit; scope `direct`. The image is
    /// black before the first. Afterwards all sums are 0.
    uint32_t pieces() const { return pieces_; }
    void record(gpu::CommandList& commands, uint32_t pass, uint32_t piece);

    const SplitLayout& layout() const { return layout_; }
    gpu::SplitRecord split() const { return gpu::device_record(layout_); }
    float glossy_threshold() const { return walk_.glossy_threshold; }
    gpu::Buffer& eye() { return eye_; }          // EyeConstants
    gpu::Buffer& points() { return points_; }    // GBufferPoint; layout().points()
    gpu::Buffer& general() { return general_; }  // GBufferGeneral; one where every surface is Lambert
    gpu::Buffer& sums() { return sums_; }        // vec3 a point: irradiance of Lambert points, radiance of others

private:
    gpu::Device& device_;
    DeviceImage& image_;
    const GBufferShadows shadows_;
    const GBufferWalk walk_;
    const SplitLayout layout_;
    const uint64_t seed_;
    const uint32_t tiles_, tiles_a_piece_, pieces_;
    gpu::Buffer eye_, sampler_, points_, general_, sums_;
    gpu::ComputePipeline pipeline_;
};

}  // namespace photond
