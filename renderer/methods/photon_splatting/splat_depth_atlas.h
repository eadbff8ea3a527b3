#pragma once
// Depth maps of beams, rasterised: the maps that splat_depth.comp traces (SplatDepthMaps says what they are), in the
// same buffer.

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/backends/gpu/raster_pass.h"
#include "renderer/scene/needs.h"

namespace photond {

/// Draws all triangles of the scene into a tile for each splat, all splats in one instanced draw. A texel's depth is
/// that at its centre, where the traced maps have their ray: the two differ along silhouettes alone, by rounding.
///
/// A splat costs three vertices a triangle of the scene, and traced a ray a texel: faster() says which is less. Masked
/// and blended surfaces, which let some light through, are not told apart, nor are instances found in trees of their
/// own: possible() says no where there are any.
class SplatDepthAtlas {
public:
    /// `resolution`: texels along a side of a map; `splats`: of the largest batch. Borrows the scene, for which
    /// possible() must be true.
    SplatDepthAtlas(const gpu::DeviceScene& scene, uint32_t resolution, uint32_t splats);
    static bool possible(const Scene& scene);
    /// Than tracing; true only where possible() is.
    static bool faster(const Needs& needs, uint64_t triangles, uint32_t resolution);
    static uint64_t device_bytes(uint32_t resolution, uint32_t splats);

    /// Of one record().
    uint32_t splats_at_once() const { return splats_at_once_; }
    /// Maps of splats [first, end) of the batch. `constants`: SplatConstants; the splats are placed.
    void record(gpu::CommandList& commands, gpu::Buffer& constants, gpu::Buffer& splats, gpu::Buffer& depth_maps,
                uint32_t first, uint32_t end);

private:
    const uint32_t resolution_, triangles_, splats_at_once_, columns_, rows_;
    gpu::Image atlas_;
    gpu::Buffer depths_;
    gpu::RasterPipeline draw_;
    gpu::ComputePipeline spread_;
};

}  // namespace photond
