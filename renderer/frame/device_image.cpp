#include "renderer/frame/device_image.h"

#include <cstring>
#include <type_traits>

#include "renderer/core/parallel.h"

namespace photond {

uint32_t DeviceImage::planes(LayerSet layers) {
    uint32_t planes = layers.needs_hits() ? 1 : 0;
    for (const LayerInfo& info : kLayers)
        if (layers.has_in_passes(info.layer)) planes += info.channel_count();
    return planes;
}

uint64_t DeviceImage::device_bytes(Size2 size, LayerSet layers) {
    return planes(layers) * size.pixels() * sizeof(float) + gpu::Counters::kBytes;
}

DeviceImage::DeviceImage(gpu::Device& device, Size2 size, LayerSet layers)
    : size_(size),
      kept_(layers),
      layers_(device, "pass_image", planes(layers) * size.pixels() * sizeof(float)),
      counters_(device),
      host_layers_(device, "readback", layers_.bytes(), gpu::MemoryKind::Readback) {}

uint32_t DeviceImage::plane_of(Layer layer) const {
    if (!kept_.has_in_passes(layer)) return NO_PLANE;
    uint32_t plane = 0;
    for (const LayerInfo& info : kLayers) {
        if (info.layer == layer) break;
        if (kept_.has_in_passes(info.layer)) plane += info.channel_count();
    }
    return plane;
}

uint32_t DeviceImage::hit_plane() const { return kept_.needs_hits() ? planes(kept_) - 1 : NO_PLANE; }

gpu::Specialization DeviceImage::plane(uint32_t id, Layer layer) const { return gpu::specialize(id, plane_of(layer)); }

std::vector<gpu::Specialization> DeviceImage::specialization() const {
    static_assert(static_cast<uint32_t>(Layer::Direct) * 3 == PLANE_DIRECT &&
                  static_cast<uint32_t>(Layer::Indirect) * 3 == PLANE_INDIRECT);
    return {gpu::specialize(PLANE_HIT_ID, hit_plane()), gpu::specialize(PLANES_ID, planes(kept_))};
}

void DeviceImage::record_clear(gpu::CommandList& commands) {
    commands.fill(layers_, 0);
    counters_.record_clear(commands);
}

void DeviceImage::record_readback(gpu::CommandList& commands) {
    const gpu::Scope scope(commands, "readback");
    commands.copy(layers_, 0, host_layers_, 0, layers_.bytes());
    commands.host_reads(host_layers_);
    counters_.record_readback(commands);
}

void DeviceImage::read(PassImage& image, Counts& counts, const dvec3& origin) const {
    const size_t pixels = size_.pixels();
    const auto* floats = reinterpret_cast<const float*>(host_layers_.mapped());
    image.each_layer([&]<class Value>(const LayerInfo& info, std::vector<Value>& to) {
        const float* from = floats + plane_of(info.layer) * pixels;
        if constexpr (std::is_same_v<Value, Rgb>)
            parallel_for(pixels, 4096, [&](size_t i) { to[i] = {from[3 * i], from[3 * i + 1], from[3 * i + 2]}; });
        else
            std::memcpy(to.data(), from, pixels * sizeof(float));
    });
    if (!image.hit.empty()) {
        const float* from = floats + hit_plane() * pixels;
        std::vector<Rgb>& positions = image.of<Layer::Position>();
        for (size_t i = 0; i < pixels; ++i) {
            image.hit[i] = from[i] != 0;
            if (image.hit[i] && !positions.empty()) positions[i] = vec3(dvec3(positions[i]) + origin);
        }
    }
    counters_.read(counts);
}

}  // namespace photond
