#include "renderer/methods/visibility_filtering/visibility_lists_gpu.h"

#include <algorithm>
#include <string>

#include "protocol/error.h"

namespace photond {

namespace {

std::string list_shader(const char* name) { return "renderer/methods/visibility_filtering/" + std::string(name); }

/// Null where rays are not counted.
std::unique_ptr<gpu::ComputePipeline> make_expected(const gpu::DeviceScene& scene,
                                                    const VisibilityFilteringParams& params) {
    if (params.lists != ListKind::Counts) return nullptr;
    return std::make_unique<gpu::ComputePipeline>(scene.device(), list_shader("expected_rays.comp"),
                                                  sizeof(gpu::ListsPush), &scene.set(), scene.specialization({}));
}

}  // namespace

VisibilityListsGpu::VisibilityListsGpu(const gpu::DeviceScene& scene, GBufferGpu& points, PointProxiesGpu& proxies,
                                       SparseVoxelOctreeGpu* tree, gpu::Buffer& constants, gpu::Buffer& counters,
                                       const VisibilityFilteringParams& params, KeptListsGpu* kept)
    : device_(scene.device()),
      points_(points),
      proxies_(proxies),
      tree_(tree),
      kept_(kept),
      constants_(constants),
      counters_(counters),
      size_(lists_of(points.layout().size, params.march_subsampling)),
      rays_(params.rays),
      kind_(params.lists),
      march_(device_, list_shader(tree ? "march_svo.comp" : "march.comp"), sizeof(gpu::ListsPush), &scene.set(),
             scene.specialization(std::vector{gpu::specialize(WORLD_RAYS_ID, params.world_rays),
                                              gpu::specialize(KEEPS_LISTS_ID, kept != nullptr),
                                              gpu::specialize(LISTS_ID, static_cast<uint32_t>(params.lists))})),
      expected_(make_expected(scene, params)),
      filter_(device_, list_shader("visibility_filter.comp"), sizeof(gpu::ListsPush), &scene.set(),
              scene.specialization(std::vector{gpu::specialize(KEEPS_LISTS_ID, kept != nullptr),
                                               gpu::specialize(LISTS_ID, static_cast<uint32_t>(params.lists))})) {}

uint32_t VisibilityListsGpu::words_before(ListKind kind, uint32_t voxels) {
    return kind == ListKind::Counts ? 2 * voxels : (voxels + 31) / 32;
}
uint32_t VisibilityListsGpu::words_after(ListKind kind, uint32_t voxels) {
    switch (kind) {
        case ListKind::Counts: return voxels + 1;
        case ListKind::Bits: return words_before(kind, voxels);
        case ListKind::Indices: break;
    }
    return voxels + 1;
}

Size2 VisibilityListsGpu::lists_of(Size2 size, uint32_t march_subsampling) {
    const auto along = [=](uint32_t pixels) { return (pixels + march_subsampling - 1) / march_subsampling; };
    return {along(size.width), along(size.height)};
}

uint64_t VisibilityListsGpu::device_bytes(Size2 size, const VisibilityFilteringParams& params) {
    const uint32_t voxels = PointProxiesGpu::guess_voxels(params.voxels);
    const uint64_t words = uint64_t{words_before(params.lists, voxels)} + words_after(params.lists, voxels);
    return lists_of(size, params.march_subsampling).pixels() * words * sizeof(uint32_t);
}

void VisibilityListsGpu::make_room(uint32_t voxels) {
    const auto bytes_of = [&](uint32_t words) { return uint64_t{count()} * words * sizeof(uint32_t); };
    const uint64_t after = bytes_of(words_after(kind_, voxels));
    const uint64_t words = std::max(after, bytes_of(words_before(kind_, voxels))) / sizeof(uint32_t);
    if (words > UINT32_MAX)
        throw Error(ErrorCode::OutOfMemory, "the lists of " + std::to_string(voxels) + " voxels have " +
                                                std::to_string(words) +
                                                " words, and at most 4294967295 can be numbered");
    if (lists_.bytes() >= after) return;
    before_filter_ = {}, lists_ = {};
    before_filter_ = gpu::Buffer(device_, "visibility_lists", bytes_of(words_before(kind_, voxels)));
    lists_ = gpu::Buffer(device_, "visibility_lists", after);
}

uint32_t VisibilityListsGpu::lists_a_piece() const { return std::max(device_.paths_per_submit() / rays_, 64u); }

uint32_t VisibilityListsGpu::pieces() const { return (count() + lists_a_piece() - 1) / lists_a_piece(); }

void VisibilityListsGpu::record_expected(gpu::CommandList& commands, uint32_t first, uint32_t end) {
    commands.bind(*expected_, {gpu::read("constants", constants_), gpu::read("points", points_.points()),
                               gpu::read("grid_places", proxies_.sorted().places),
                               gpu::read("voxels", proxies_.voxels()), gpu::write("lists", before_filter_)});
    commands.push(gpu::ListsPush{first, end});
    commands.dispatch_threads(uint64_t{end - first} * proxies_.grid().slots, LISTS_GROUP);
}

void VisibilityListsGpu::record_march(gpu::CommandList& commands, uint32_t first, uint32_t end) {
    if (expected_)
        record_expected(commands, first, end);
    else if (first == 0)
        commands.fill(before_filter_, 0);
    gpu::Buffer& nothing = lists_;  // what no place is written to
    std::vector<gpu::Binding> bindings = {gpu::read("constants", constants_),
                                          gpu::read("points", points_.points()),
                                          gpu::read("general_points", points_.general()),
                                          gpu::read_write("lists", before_filter_),
                                          gpu::read_write("device_counters", counters_),
                                          gpu::write("met_places", kept_ ? kept_->met_places() : nothing)};
    append_ray_ends(bindings, proxies_, tree_);
    commands.bind(march_, bindings);
    commands.push(gpu::ListsPush{first, end});
    commands.dispatch_threads(uint64_t{end - first} * rays_, LISTS_GROUP);
    if (kept_) kept_->record(commands, before_filter_, first, end);
}

void VisibilityListsGpu::record(gpu::CommandList& commands, uint32_t piece) {
    const uint32_t first = piece * lists_a_piece(), end = std::min(first + lists_a_piece(), count());
    {
        const gpu::Scope scope(commands, "march");
        record_march(commands, first, end);
    }
    if (end < count()) return;
    if (kept_) kept_->record_readback(commands);
    const gpu::Scope scope(commands, "visibility_filter");
    commands.fill(lists_, 0);
    gpu::Buffer& nothing = constants_;
    commands.bind(filter_, {gpu::read("constants", constants_), gpu::read("points", points_.points()),
                            gpu::read("lists", before_filter_), gpu::read("lit_words", proxies_.lit_words()),
                            gpu::write("filtered", lists_),
                            gpu::read("taking_points", kept_ ? kept_->taking_points() : nothing)});
    commands.push(gpu::ListsPush{0, count()});
    commands.dispatch_threads(uint64_t{count()} * LISTS_GROUP, LISTS_GROUP);
}

}  // namespace photond
