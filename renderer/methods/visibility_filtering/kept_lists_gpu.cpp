#include "renderer/methods/visibility_filtering/kept_lists_gpu.h"

#include <string>

#include "renderer/methods/visibility_filtering/visibility_lists_shared.h"

namespace photond {

namespace {

constexpr const char* kKeptLists = "kept_lists";

uint64_t met_bytes(const KeptLayout& layout) { return layout.points() * layout.rays * sizeof(vec3); }
uint64_t taking_bytes(const KeptLayout& layout) { return layout.points() * sizeof(gpu::TakingPoint); }

uint64_t kept_bytes(const KeptLayout& layout) {
    return layout.points() * sizeof(gpu::KeptPoint) + layout.places() * sizeof(vec3);
}
uint64_t taken_bytes(const KeptLayout& layout) { return layout.places() * sizeof(vec3); }

gpu::KeptConstants constants_for(const ListsBetweenFrames& frames) {
    gpu::KeptConstants kept{frames.before().camera,
                            static_cast<uint32_t>(frames.before().points.size()),
                            frames.before().layout.most_lists,
                            static_cast<uint32_t>(frames.moved().size()),
                            {}};
    for (size_t i = 0; i < frames.moved().size(); ++i) kept.moved[i] = {frames.moved()[i].min, frames.moved()[i].max};
    return kept;
}

template <class T>
std::vector<T> copy_of(const gpu::Buffer& buffer) {
    const std::span<const T> values = buffer.as<const T>();
    return {values.begin(), values.end()};
}

}  // namespace

void append_ray_ends(std::vector<gpu::Binding>& bindings, PointProxiesGpu& proxies, SparseVoxelOctreeGpu* tree) {
    bindings.insert(bindings.end(), {gpu::read("grid_starts", proxies.sorted().starts),
                                     gpu::read("grid_places", proxies.sorted().places)});
    if (!tree) return;
    bindings.insert(bindings.end(), {gpu::read("svo_constants", tree->constants()),
                                     gpu::read("svo_nodes", tree->nodes()), gpu::read("svo_bricks", tree->bricks())});
}

KeptListsGpu::KeptListsGpu(const gpu::DeviceScene& scene, GBufferGpu& points, PointProxiesGpu& proxies,
                           SparseVoxelOctreeGpu* tree, gpu::Buffer& constants, gpu::Buffer& counters,
                           const VisibilityFilteringParams& params, const ListsBetweenFrames& frames)
    : points_(points),
      proxies_(proxies),
      tree_(tree),
      constants_(constants),
      counters_(counters),
      kept_(constants_for(frames)),
      kept_words_(scene.device(), kKeptLists, kept_bytes(frames.before().layout)),
      met_places_(scene.device(), kKeptLists, met_bytes(frames.before().layout)),
      taken_places_(scene.device(), kKeptLists, taken_bytes(frames.before().layout)),
      taking_points_(scene.device(), kKeptLists, taking_bytes(frames.before().layout)),
      host_met_places_(scene.device(), "readback", met_places_.bytes(), gpu::MemoryKind::Readback),
      host_taken_places_(scene.device(), "readback", taken_places_.bytes(), gpu::MemoryKind::Readback),
      host_taking_points_(scene.device(), "readback", taking_points_.bytes(), gpu::MemoryKind::Readback),
      pipeline_(
          scene.device(),
          std::string("renderer/methods/visibility_filtering/") + (tree ? "kept_lists_svo.comp" : "kept_lists.comp"),
          sizeof(gpu::ListsPush), &scene.set(),
          scene.specialization(std::vector{gpu::specialize(LISTS_ID, static_cast<uint32_t>(params.lists))})) {
    const std::span points_before = std::as_bytes(std::span(frames.before().points));
    gpu::upload(scene.device(), kept_words_, points_before);
    gpu::upload(scene.device(), kept_words_, std::as_bytes(std::span(frames.before().places)), points_before.size());
}

uint64_t KeptListsGpu::device_bytes(const KeptLayout& layout) {
    return kept_bytes(layout) + taken_bytes(layout) + met_bytes(layout) + taking_bytes(layout);
}

void KeptListsGpu::record(gpu::CommandList& commands, gpu::Buffer& lists, uint32_t first, uint32_t end) {
    std::vector<gpu::Binding> bindings = {gpu::read("constants", constants_),
                                          gpu::read("points", points_.points()),
                                          gpu::read_write("lists", lists),
                                          gpu::read("kept_words", kept_words_),
                                          gpu::write("taking_points", taking_points_),
                                          gpu::write("taken_places", taken_places_),
                                          gpu::read_write("device_counters", counters_)};
    append_ray_ends(bindings, proxies_, tree_);
    commands.bind(pipeline_, bindings);
    commands.push(gpu::ListsPush{first, end});
    commands.dispatch_threads(uint64_t{end - first} * LISTS_GROUP, LISTS_GROUP);
}

void KeptListsGpu::record_readback(gpu::CommandList& commands) {
    commands.copy(met_places_, 0, host_met_places_, 0, met_places_.bytes());
    commands.copy(taken_places_, 0, host_taken_places_, 0, taken_places_.bytes());
    commands.copy(taking_points_, 0, host_taking_points_, 0, taking_points_.bytes());
    commands.host_reads(host_met_places_);
    commands.host_reads(host_taken_places_);
    commands.host_reads(host_taking_points_);
}

void KeptListsGpu::leave(ListsBetweenFrames& frames) const {
    frames.leave(copy_of<gpu::TakingPoint>(host_taking_points_), copy_of<vec3>(host_met_places_),
                 copy_of<vec3>(host_taken_places_));
}

}  // namespace photond
