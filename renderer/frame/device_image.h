#pragma once
// What one pass makes on the device: its layers and what it counted, and their way to the host.

#include <vector>

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

    /// What all shaders that include device_image.glsl ask for.
    std::vector<gpu::Specialization> specialization() const;
    /// Where a layer is, for the shaders that fill it: their constant of that id.
    gpu::Specialization plane(uint32_t id, Layer layer) const;
    gpu::Buffer& layers() { return layers_; }
    gpu::Buffer& counters() { return counters_.buffer(); }

    /// Black, and nothing counted.
    void record_clear(gpu::CommandList& commands);
    /// To the host: stage `readback`.
    void record_readback(gpu::CommandList& commands);
    /// Once that has been waited for. `origin` is added to positions (Scene::origin).
    void read(PassImage& image, Counts& counts, const dvec3& origin) const;

private:
    /// The plane it begins with; NO_PLANE where it is not kept.
    uint32_t plane_of(Layer layer) const;
    uint32_t hit_plane() const;
    static uint32_t planes(LayerSet layers);

    Size2 size_;
    LayerSet kept_;
    gpu::Buffer layers_;
    gpu::Counters counters_;
    gpu::Buffer host_layers_;
};

}  // namespace photond
