#include "renderer/frame/device_image.h"

#include <cstring>

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

std::vector<gpu::Specialization> DeviceImage::specialization() const {
    static_assert(static_cast<uint32_t>(Layer::Direct) * 3 == PLANE_DIRECT &&
                  static_cast<uint32_t>(Layer::Indirect) * 3 == PLANE_INDIRECT);
    return {gpu::specialize(PLANE_CAUSTIC_ID, plane_of(Layer::Caustic)),
            gpu::specialize(PLANE_ALBEDO_ID, plane_of(Layer::Albedo)),
            gpu::specialize(PLANE_NORMAL_ID, plane_of(Layer::Normal)),
            gpu::specialize(PLANE_POSITION_ID, plane_of(Layer::Position)),
            gpu::specialize(PLANE_DEPTH_ID, plane_of(Layer::Depth)),
            gpu::specialize(PLANE_PHOTON_COUNT_ID, plane_of(Layer::PhotonCount)),
            gpu::specialize(PLANE_OVERLAP_ID, plane_of(Layer::Overlap)),
            gpu::specialize(PLANE_CLAMPED_ID, plane_of(Layer::Clamped)),
            gpu::specialize(PLANE_VOXELS_ID, plane_of(Layer::Voxels)),
            gpu::specialize(PLANE_VPLS_ID, plane_of(Layer::Vpls)),
            gpu::specialize(PLANE_SPLIT_NORMAL_ID, plane_of(Layer::SplitNormal)),
            gpu::specialize(PLANE_SPLIT_INDIRECT_ID, plane_of(Layer::SplitIndirect)),
            gpu::specialize(PLANE_HIT_ID, hit_plane()),
            gpu::specialize(PLANES_ID, planes(kept_))};
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
    const auto copy_colours = [&](uint32_t plane, std::vector<Rgb>& to) {
        if (plane == NO_PLANE || to.empty()) return;
        const float* from = floats + plane * pixels;
        parallel_for(pixels, 4096, [&](size_t i) { to[i] = {from[3 * i], from[3 * i + 1], from[3 * i + 2]}; });
    };
    const auto copy_values = [&](uint32_t plane, std::vector<float>& to) {
        if (plane == NO_PLANE || to.empty()) return;
        std::memcpy(to.data(), floats + plane * pixels, pixels * sizeof(float));
    };
    copy_colours(PLANE_EMITTED, image.emitted);
    copy_colours(PLANE_DIRECT, image.direct);
    copy_colours(PLANE_INDIRECT, image.indirect);
    copy_colours(plane_of(Layer::Caustic), image.caustic);
    copy_colours(plane_of(Layer::Albedo), image.albedo);
    copy_colours(plane_of(Layer::Normal), image.normal);
    copy_colours(plane_of(Layer::Position), image.position);
    copy_colours(plane_of(Layer::Clamped), image.clamped);
    copy_colours(plane_of(Layer::Voxels), image.voxels);
    copy_colours(plane_of(Layer::SplitNormal), image.split_normal);
    copy_colours(plane_of(Layer::SplitIndirect), image.split_indirect);
    copy_values(plane_of(Layer::Depth), image.depth);
    copy_values(plane_of(Layer::PhotonCount), image.photon_count);
    copy_values(plane_of(Layer::Overlap), image.overlap);
    copy_values(plane_of(Layer::Vpls), image.vpls);
    if (!image.hit.empty()) {
        const float* from = floats + hit_plane() * pixels;
        for (size_t i = 0; i < pixels; ++i) {
            image.hit[i] = from[i] != 0;
            if (image.hit[i] && !image.position.empty()) image.position[i] = vec3(dvec3(image.position[i]) + origin);
        }
    }
    counters_.read(counts);
}

}  // namespace photond
