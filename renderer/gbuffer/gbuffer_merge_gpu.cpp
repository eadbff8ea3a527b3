#include "renderer/gbuffer/gbuffer_merge_gpu.h"

namespace photond {

namespace {

bool filters(const gpu::GeometryFilter& filter) { return filter.width > 1; }

}  // namespace

GBufferMergeGpu::GBufferMergeGpu(const gpu::DeviceScene& scene, GBufferGpu& buffer, DeviceImage& image, LayerSet layers,
                                 const gpu::GeometryFilter& filter)
    : buffer_(buffer),
      image_(image),
      filter_settings_(filter),
      merge_(scene.device(), "renderer/gbuffer/gbuffer_merge.comp", sizeof(gpu::SplitRecord)) {
    if (filters(filter)) {
        filtered_ = gpu::Buffer(scene.device(), "g_buffer", uint64_t{buffer.layout().points()} * sizeof(vec3));
        filter_.emplace(scene.device(), "renderer/gbuffer/gbuffer_filter.comp", sizeof(gpu::GBufferFilterPush));
    }
    if (layers.has(Layer::SplitNormal) || layers.has(Layer::SplitIndirect))
        split_layers_.emplace(scene.device(), "renderer/gbuffer/gbuffer_split_layers.comp", sizeof(gpu::SplitRecord));
}

uint64_t GBufferMergeGpu::device_bytes(Size2 size, uint32_t split_side, const gpu::GeometryFilter& filter) {
    return filters(filter) ? uint64_t{SplitLayout(size, split_side).points()} * sizeof(vec3) : 0;
}

void GBufferMergeGpu::record_split_layers(gpu::CommandList& commands) {
    if (!split_layers_) return;
    commands.bind(*split_layers_, {gpu::read_write("device_layers", image_.layers()),
                                   gpu::read("points", buffer_.points()), gpu::read("sums", buffer_.sums())});
    commands.push(buffer_.split());
    commands.dispatch_threads(buffer_.layout().size.pixels(), SPLIT_GROUP);
}

void GBufferMergeGpu::record(gpu::CommandList& commands) {
    if (filter_) {
        const gpu::Scope scope(commands, "filter");
        commands.bind(*filter_, {gpu::read("points", buffer_.points()), gpu::read("sums", buffer_.sums()),
                                 gpu::write("filtered", filtered_)});
        commands.push(gpu::GBufferFilterPush{buffer_.split(), filter_settings_});
        commands.dispatch_threads(buffer_.layout().points(), SPLIT_GROUP);
    }
    const gpu::Scope scope(commands, "merge");
    commands.bind(merge_, {gpu::read_write("device_layers", image_.layers()), gpu::read("points", buffer_.points()),
                           gpu::read("sums", filter_ ? filtered_ : buffer_.sums())});
    commands.push(buffer_.split());
    commands.dispatch_threads(buffer_.layout().size.pixels(), SPLIT_GROUP);
}

}  // namespace photond
