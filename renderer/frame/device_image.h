#pragma once
// What one pass makes on the device: its layers and what it counted, and their way to the host.

#include <array>

#include "renderer/backends/gpu/counters.h"
#include "renderer/film/film.h"
#include "renderer/frame/device_image_shared.h"

namespace photond {

/// Layers and counters of one pass; a method that overlaps passes has two.
class DeviceImage {
public:
    DeviceImage() = default;  // holds nothing
    DeviceImage(gpu::Device& device, Size2 size, LayerSet layers);
    /// Bytes on the device, and of the host's copy.
    static uint64_t device_bytes(Size2 size, LayerSet layers);
    static uint64_t host_bytes(Size2 size, LayerSet layers) { return device_bytes(size, layers); }

    /// What shaders call `device_layers` (device_image.glsl).
    gpu::Buffer& layers() { return layers_; }
    gpu::Buffer& counters() { return counters_.buffer(); }

    /// Black, and nothing counted.
    void record_clear(gpu::CommandList& commands);
    /// To the host: stage `readback`.
    void record_readback(gpu::CommandList& commands);
    /// Once that has been waited for. `origin` is added to positions (Scene::origin).
    void read(PassImage& image, Counts& counts, const dvec3& origin) const;

private:
    /// Numbers of words, by layer and LAYER_HITS (device_image_shared.h).
    using Places = std::array<uint32_t, LAYER_PLACES>;
    static Places places_of(Size2 size, LayerSet kept);
    static uint32_t planes(LayerSet layers);

    Size2 size_;
    Places places_{};
    gpu::Buffer layers_;
    gpu::Counters counters_;
    gpu::Buffer host_layers_;
};

}  // namespace photond
