#pragma once
// From the sums of a GBufferGpu into the image's indirect light.

#include <optional>

#include "renderer/gbuffer/gbuffer_gpu.h"
#include "renderer/gbuffer/geometry_filter_shared.h"

namespace photond {

class GBufferMergeGpu {
public:
    /// Borrows the points and the image. `filter`: a width below 2 is none.
    GBufferMergeGpu(const gpu::DeviceScene& scene, GBufferGpu& buffer, DeviceImage& image, LayerSet layers,
                    const gpu::GeometryFilter& filter);
    static uint64_t device_bytes(Size2 size, uint32_t split_side, const gpu::GeometryFilter& filter);

    /// The layers `split_normal` and `split_indirect`, where they are kept: what the sums hold now.
    void record_split_layers(gpu::CommandList& commands);
    /// Filters the sums of Lambert points, scope `filter`, and adds them to the image, scope `merge`.
    void record(gpu::CommandList& commands);

private:
    GBufferGpu& buffer_;
    DeviceImage& image_;
    const gpu::GeometryFilter filter_settings_;
    gpu::Buffer filtered_;
    std::optional<gpu::ComputePipeline> filter_, split_layers_;
    gpu::ComputePipeline merge_;
};

}  // namespace photond
