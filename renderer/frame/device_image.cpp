#include "renderer/frame/device_image.h"

#include <cstring>
#include <span>
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
    return sizeof(Places) + planes(layers) * size.pixels() * sizeof(float) + gpu::Counters::kBytes;
}

DeviceImage::Places DeviceImage::places_of(Size2 size, LayerSet kept) {
    static_assert(LAYER_HITS == kLayerCount && sizeof(Places) % 4 == 0);
    Places places{};
    uint64_t next = places.size();
    const auto keep = [&](size_t number, uint32_t channels) {
        places[number] = static_cast<uint32_t>(next);
        next += channels * size.pixels();
    };
    for (const LayerInfo& info : kLayers)
        if (kept.has_in_passes(info.layer)) keep(static_cast<size_t>(info.layer), info.channel_count());
    if (kept.needs_hits()) keep(LAYER_HITS, 1);
    return places;  // a buffer of more words than 32 bits number is refused as it is made
}

DeviceImage::DeviceImage(gpu::Device& device, Size2 size, LayerSet layers)
    : size_(size),
      places_(places_of(size, layers)),
      layers_(device, "pass_image", sizeof(Places) + planes(layers) * size.pixels() * sizeof(float)),
      counters_(device),
      host_layers_(device, "readback", layers_.bytes(), gpu::MemoryKind::Readback) {
    gpu::upload(device, layers_, std::as_bytes(std::span(places_)));
}

void DeviceImage::record_clear(gpu::CommandList& commands) {
    commands.fill(layers_, 0, sizeof(Places), layers_.bytes() - sizeof(Places));
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
        const float* from = floats + places_[static_cast<size_t>(info.layer)];
        if constexpr (std::is_same_v<Value, Rgb>)
            parallel_for(pixels, 4096, [&](size_t i) { to[i] = {from[3 * i], from[3 * i + 1], from[3 * i + 2]}; });
        else
            std::memcpy(to.data(), from, pixels * sizeof(float));
    });
    if (!image.hit.empty()) {
        const float* from = floats + places_[LAYER_HITS];
        std::vector<Rgb>& positions = image.of<Layer::Position>();
        for (size_t i = 0; i < pixels; ++i) {
            image.hit[i] = from[i] != 0;
            if (image.hit[i] && !positions.empty()) positions[i] = vec3(dvec3(positions[i]) + origin);
        }
    }
    counters_.read(counts);
}

}  // namespace photond
