#include "renderer/methods/visibility_filtering/visibility_lists_gpu.h"

#include <algorithm>

namespace photond {

namespace {

std::string list_shader(const char* name) { return "renderer/methods/visibility_filtering/" + std::string(name); }

}  // namespace

VisibilityListsGpu::VisibilityListsGpu(const gpu::DeviceScene& scene, GBufferGpu& points, PointProxiesGpu& proxies,
                                       SparseVoxelOctreeGpu* tree, gpu::Buffer& constants, gpu::Buffer& counters,
                                       const VisibilityFilteringParams& params)
    : device_(scene.device()),
      points_(points),
      proxies_(proxies),
      tree_(tree),
      constants_(constants),
      counters_(counters),
      size_(lists_of(points.layout().size, params.march_subsampling)),
      rays_(params.rays),
      march_(device_, list_shader(tree ? "march_svo.comp" : "march.comp"), sizeof(gpu::ListsPush), &scene.set(),
             scene.specialization(std::vector{gpu::specialize(WORLD_RAYS_ID, params.world_rays)})),
      filter_(device_, list_shader("visibility_filter.comp"), sizeof(gpu::ListsPush), &scene.set(),
              scene.specialization({})) {}

Size2 VisibilityListsGpu::lists_of(Size2 size, uint32_t march_subsampling) {
    const auto along = [=](uint32_t pixels) { return (pixels + march_subsampling - 1) / march_subsampling; };
    return {along(size.width), along(size.height)};
}

uint64_t VisibilityListsGpu::device_bytes(Size2 size, const VisibilityFilteringParams& params) {
    const uint64_t words = (uint64_t{params.voxels} * params.voxels * params.voxels + 31) / 32;
    return 2 * lists_of(size, params.march_subsampling).pixels() * words * sizeof(uint32_t);
}

void VisibilityListsGpu::make_room(uint32_t words) {
    const uint64_t bytes = uint64_t{count()} * words * sizeof(uint32_t);
    if (lists_.bytes() >= bytes) return;
    before_filter_ = {}, lists_ = {};
    before_filter_ = gpu::Buffer(device_, "visibility_lists", bytes);
    lists_ = gpu::Buffer(device_, "visibility_lists", bytes);
}

uint32_t VisibilityListsGpu::lists_a_piece() const { return std::max(device_.paths_per_submit() / rays_, 64u); }

uint32_t VisibilityListsGpu::pieces() const { return (count() + lists_a_piece() - 1) / lists_a_piece(); }

void VisibilityListsGpu::record(gpu::CommandList& commands, uint32_t piece) {
    const uint32_t first = piece * lists_a_piece(), end = std::min(first + lists_a_piece(), count());
    {
        const gpu::Scope scope(commands, "march");
        if (piece == 0) commands.fill(before_filter_, 0);
        std::vector<gpu::Binding> bindings = {gpu::read("constants", constants_), gpu::read("points", points_.points()),
                                              gpu::read("general_points", points_.general()),
                                              gpu::read_write("lists", before_filter_),
                                              gpu::read_write("device_counters", counters_)};
        if (tree_)
            bindings.insert(bindings.end(),
                            {gpu::read("svo_constants", tree_->constants()), gpu::read("svo_nodes", tree_->nodes()),
                             gpu::read("svo_bricks", tree_->bricks())});
        else
            bindings.insert(bindings.end(), {gpu::read("grid_starts", proxies_.sorted().starts),
                                             gpu::read("grid_places", proxies_.sorted().places)});
        commands.bind(march_, bindings);
        commands.push(gpu::ListsPush{first, end});
        commands.dispatch_threads(uint64_t{end - first} * rays_, LISTS_GROUP);
    }
    if (end < count()) return;
    const gpu::Scope scope(commands, "visibility_filter");
    commands.fill(lists_, 0);
    commands.bind(filter_, {gpu::read("constants", constants_), gpu::read("points", points_.points()),
                            gpu::read("lists", before_filter_), gpu::read("lit_words", proxies_.lit_words()),
                            gpu::write("filtered", lists_)});
    commands.push(gpu::ListsPush{0, count()});
    commands.dispatch_threads(uint64_t{count()} * LISTS_GROUP, LISTS_GROUP);
}

}  // namespace photond
