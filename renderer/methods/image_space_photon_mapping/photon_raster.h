#pragma once
// Photons drawn over the pixels they light, beside photon_scatter.comp, which goes through them tile by tile: the way
// of both sources.

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/gbuffer/split_buffer.h"
#include "renderer/methods/image_space_photon_mapping/params.h"
#include "renderer/splats/added_images.h"

namespace photond {

/// Each photon's quad, icosahedron or box is drawn into a float image that blends by adding, in the order of the
/// photons: the same bits every time. Pixels that cannot be lit so (drawn_pixels.glsl) are left to tiles. In the
/// accounts as "drawn_photons", 32 bytes a lit pixel.
class PhotonRaster {
public:
    /// `specialization`: that of photon_scatter.comp.
    PhotonRaster(const gpu::DeviceScene& scene, const SplitLayout& layout, PhotonFootprint footprint,
                 std::span<const gpu::Specialization> specialization);
    static uint64_t device_bytes(const SplitLayout& layout);

    /// What the shaders bind of a pass.
    struct Pass {
        gpu::Buffer &constants, &points, &starts, &places, &powers, &sums, &layers;
    };
    /// Photons of a draw, so that cancelling is answered soon, where a footprint covers so many pixels.
    uint32_t photons_at_once(double pixels) const;
    /// Photons of a map, half open. `clear`: the first of the map.
    void record(gpu::CommandList& commands, const Pass& pass, uint32_t map, uint32_t first, uint32_t end, bool clear);
    /// After the map's last: to the points' sums.
    void record_sums(gpu::CommandList& commands, const Pass& pass, uint32_t map);

private:
    gpu::Device& device_;
    const uint32_t pixels_, vertices_;
    AddedImages image_;
    gpu::RasterPipeline draw_;
    gpu::ComputePipeline sum_;
};

}  // namespace photond
