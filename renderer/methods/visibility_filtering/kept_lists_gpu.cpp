#include "renderer/methods/visibility_filtering/kept_lists_gpu.h"

#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"

namespace photond {

namespace {

constexpr const char* kStructure = "kept_lists";

uint64_t met_bytes(const KeptLayout& layout) { return layout.points() * layout.rays * sizeof(vec3); }
uint64_t taking_bytes(const KeptLayout& layout) { return layout.points() * sizeof(gpu::TakingPoint); }

gpu::KeptConstants constants_for(const LeftLists& before) { return {before.camera, before.layout.most_lists}; }

template <class T>
std::vector<T> copy_of(const gpu::Buffer& buffer) {
    const std::span<const T> values = buffer.as<const T>();
    return {values.begin(), values.end()};
}

}  // namespace

KeptListsGpu::KeptListsGpu(const gpu::DeviceScene& scene, GBufferGpu& points, PointProxiesGpu& proxies,
                           gpu::Buffer& constants, const VisibilityFilteringParams& params, const LeftLists& before)
    : points_(points),
      proxies_(proxies),
      constants_(constants),
      kept_points_(gpu::make_buffer(scene.device(), kStructure, std::span(before.points))),
      kept_places_(gpu::make_buffer(scene.device(), kStructure, std::span(before.places))),
      met_places_(scene.device(), kStructure, met_bytes(before.layout)),
      taking_points_(scene.device(), kStructure, taking_bytes(before.layout)),
      host_met_places_(scene.device(), "readback", met_bytes(before.layout), gpu::MemoryKind::Readback),
      host_taking_points_(scene.device(), "readback", taking_bytes(before.layout), gpu::MemoryKind::Readback),
      pipeline_(scene.device(), "renderer/methods/visibility_filtering/kept_lists.comp", sizeof(gpu::ListsPush),
                &scene.set(),
                scene.specialization(std::vector{gpu::specialize(LISTS_ID, static_cast<uint32_t>(params.lists))})) {
    const gpu::KeptConstants kept = constants_for(before);
    kept_ = gpu::make_buffer(scene.device(), kStructure, std::span(&kept, 1));
}

uint64_t KeptListsGpu::device_bytes(const KeptLayout& layout) {
    return sizeof(gpu::KeptConstants) + layout.points() * sizeof(gpu::KeptPoint) + layout.places() * sizeof(vec3) +
           met_bytes(layout) + taking_bytes(layout);
}

void KeptListsGpu::record(gpu::CommandList& commands, gpu::Buffer& lists, uint32_t first, uint32_t end) {
    commands.bind(
        pipeline_,
        {gpu::read("constants", constants_), gpu::read("points", points_.points()), gpu::read_write("lists", lists),
         gpu::read("kept", kept_), gpu::read("kept_points", kept_points_), gpu::read("kept_places", kept_places_),
         gpu::write("taking_points", taking_points_), gpu::read("grid_starts", proxies_.sorted().starts),
         gpu::read("grid_places", proxies_.sorted().places)});
    commands.push(gpu::ListsPush{first, end});
    commands.dispatch_threads(uint64_t{end - first} * LISTS_GROUP, LISTS_GROUP);
}

void KeptListsGpu::record_readback(gpu::CommandList& commands) {
    commands.copy(met_places_, 0, host_met_places_, 0, met_places_.bytes());
    commands.copy(taking_points_, 0, host_taking_points_, 0, taking_points_.bytes());
    commands.host_reads(host_met_places_);
    commands.host_reads(host_taking_points_);
}

void KeptListsGpu::leave(ListsBetweenFrames& frames) const {
    frames.leave(copy_of<gpu::TakingPoint>(host_taking_points_), copy_of<vec3>(host_met_places_));
}

}  // namespace photond
