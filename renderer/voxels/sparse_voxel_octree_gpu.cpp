#include "renderer/voxels/sparse_voxel_octree_gpu.h"

#include "renderer/scene/scene.h"
#include "renderer/voxels/sparse_voxel_octree.h"

namespace photond {

namespace {

constexpr uint32_t kMostColumns = 1u << 31;
constexpr uint64_t kMostNodes = 1ull << 30;
constexpr const char* kTree = "voxel_tree";
constexpr const char* kScratch = "voxel_fragments";

uint32_t word(uint64_t count) { return static_cast<uint32_t>(count); }
uint64_t with_slack(uint64_t count) { return count + count / 4; }

}  // namespace

SparseVoxelOctreeGpu::Room SparseVoxelOctreeGpu::expected_room(const Scene& scene, const VoxelGrid& grid) {
    const SparseVoxelOctree::Estimate expected = SparseVoxelOctree::estimate(scene, grid, true);
    constexpr uint64_t kLeast = 1024;
    const auto roomy = [](uint64_t count) { return std::min<uint64_t>(with_slack(count) + kLeast, kMostNodes); };
    return {roomy(expected.fragments), roomy(expected.nodes), roomy(expected.bricks), roomy(expected.voxels)};
}

uint64_t SparseVoxelOctreeGpu::tree_bytes(const Room& room, bool surfaces) {
    return room.nodes * sizeof(gpu::SvoNode) + room.bricks * sizeof(gpu::SvoBrick) +
           (surfaces ? (room.bricks + room.voxels) * sizeof(uint32_t) : sizeof(uint32_t));
}

uint64_t SparseVoxelOctreeGpu::scratch_bytes(const Room& room) {
    return room.fragments * sizeof(gpu::SvoFragment) + room.nodes * sizeof(uint32_t);
}

uint64_t SparseVoxelOctreeGpu::estimate_device_bytes(const Scene& scene, const VoxelGrid& grid, bool surfaces) {
    const Room room = expected_room(scene, grid);
    return tree_bytes(room, surfaces) + scratch_bytes(room) +
           (scene.triangle_count + scene.instances.size()) * sizeof(uint32_t);
}

SparseVoxelOctreeGpu::SparseVoxelOctreeGpu(const gpu::DeviceScene& scene, const VoxelGrid& grid, bool surfaces)
    : device_(scene.device()),
      scene_(scene),
      with_surfaces_(surfaces),
      host_constants_(svo_constants_of(grid)),
      constants_buffer_(device_, kTree, sizeof(gpu::SvoConstants)),
      state_(device_, kScratch, SVO_STATE_WORDS * sizeof(uint32_t)),
      host_state_(device_, "readback", state_.bytes(), gpu::MemoryKind::Readback),
      columns_(device_, kScratch, std::max<uint64_t>(scene.scene().triangle_count, 1) * sizeof(uint32_t)),
      column_tiles_(device_, kScratch, kMostColumns, SVO_GROUP),
      column_sum_(device_, std::max<uint32_t>(first_triangles_of(scene.scene()).back(), 1)),
      count_columns_(device_, "renderer/voxels/voxel_columns.comp", 0, &scene.set(), scene.specialization()),
      make_fragments_(device_, "renderer/voxels/voxel_fragments.comp", sizeof(gpu::SvoBuildPush), &scene.set(),
                      scene.specialization()),
      begin_(device_, "renderer/voxels/svo_begin.comp", sizeof(gpu::SvoBuildPush)),
      flag_(device_, "renderer/voxels/svo_flag.comp", sizeof(gpu::SvoBuildPush)),
      rank_(device_, "renderer/voxels/svo_ranks.comp", 0),
      allocate_(device_, "renderer/voxels/svo_allocate.comp", sizeof(gpu::SvoBuildPush)),
      next_(device_, "renderer/voxels/svo_next.comp", sizeof(gpu::SvoBuildPush)),
      fill_masks_(device_, "renderer/voxels/svo_masks.comp", sizeof(gpu::SvoBuildPush)),
      count_voxels_(device_, "renderer/voxels/svo_counts.comp", 0),
      fill_surfaces_(device_, "renderer/voxels/svo_surfaces.comp", sizeof(gpu::SvoBuildPush)) {
    const std::vector<uint32_t> first = first_triangles_of(scene.scene());
    first_triangles_ = gpu::make_buffer(device_, kTree, std::span(first));
    host_constants_.instance_count = word(scene.scene().instances.size());
    host_constants_.triangle_count = first.back();
    const Room room = expected_room(scene.scene(), grid);
    make_tree(room);
    make_scratch(room);
}

void SparseVoxelOctreeGpu::make_tree(const Room& room) {
    if (room.nodes > kMostNodes) throw Error(ErrorCode::OutOfMemory, "the voxels' octree has more than 2^30 nodes");
    nodes_ = {}, bricks_ = {}, surfaces_ = {};  // not both at once
    nodes_ = gpu::Buffer(device_, kTree, room.nodes * sizeof(gpu::SvoNode));
    bricks_ = gpu::Buffer(device_, kTree, room.bricks * sizeof(gpu::SvoBrick));
    const uint64_t surface_words = with_surfaces_ ? room.bricks + room.voxels : 1;
    surfaces_ = gpu::Buffer(device_, kTree, surface_words * sizeof(uint32_t));
    room_.nodes = room.nodes, room_.bricks = room.bricks, room_.voxels = room.voxels;
    write_constants();
}

void SparseVoxelOctreeGpu::make_scratch(const Room& room) {
    fragments_ = {}, ranks_ = {};
    fragments_ = gpu::Buffer(device_, kScratch, room.fragments * sizeof(gpu::SvoFragment));
    ranks_ = gpu::Buffer(device_, kScratch, std::max(room.nodes, room.bricks) * sizeof(uint32_t));
    room_.fragments = room.fragments;
    fragment_tiles_.emplace(device_, kScratch, word(room.fragments), SVO_GROUP);
    node_tiles_.emplace(device_, kScratch, word(std::max(room.nodes, room.bricks)), SVO_GROUP);
    rank_sum_.emplace(device_, word(std::max(room.nodes, room.bricks)));
}

void SparseVoxelOctreeGpu::write_constants() {
    host_constants_.surface_base = with_surfaces_ ? word(room_.bricks) : 0;
    gpu::upload(device_, constants_buffer_, std::as_bytes(std::span(&host_constants_, 1)));
}

gpu::SvoBuildPush SparseVoxelOctreeGpu::push(uint32_t level) const {
    return {.level = level,
            .levels = host_constants_.levels,
            .resolution = host_constants_.grid.resolution,
            .fragment_capacity = word(room_.fragments),
            .node_capacity = word(room_.nodes),
            .brick_capacity = word(room_.bricks),
            .surface_base = host_constants_.surface_base};
}

void SparseVoxelOctreeGpu::record_voxelise(gpu::CommandList& commands) {
    const gpu::Scope scope(commands, "voxelise");
    std::array<uint32_t, SVO_STATE_WORDS> words{};
    words[SVO_STATE_TRIANGLES] = host_constants_.triangle_count;
    commands.update(state_, words);
    commands.bind(count_columns_,
                  {gpu::read("constants", constants_buffer_), gpu::read("svo_first_triangles", first_triangles_),
                   gpu::read_write("state", state_), gpu::write("columns", columns_)});
    commands.dispatch_threads(host_constants_.triangle_count, SVO_GROUP);
    column_sum_.record(commands, columns_, columns_, {state_, SVO_STATE_TRIANGLES}, {state_, SVO_STATE_COLUMNS});
    column_tiles_.record(commands, {state_, SVO_STATE_COLUMNS});
    commands.bind(make_fragments_,
                  {gpu::read("tiles_state", column_tiles_.state()), gpu::read("constants", constants_buffer_),
                   gpu::read("svo_first_triangles", first_triangles_), gpu::read("first_columns", columns_),
                   gpu::read_write("state", state_), gpu::write("fragments", fragments_)});
    commands.push(push(0));
    column_tiles_.dispatch(commands);
}

void SparseVoxelOctreeGpu::record_level(gpu::CommandList& commands, uint32_t level) {
    commands.bind(flag_, {gpu::read("tiles_state", fragment_tiles_->state()), gpu::read("fragments", fragments_),
                          gpu::read_write("nodes", nodes_)});
    commands.push(push(level));
    fragment_tiles_->dispatch(commands);
    node_tiles_->record(commands, {state_, SVO_STATE_LEVEL_NODES});
    commands.bind(rank_, {gpu::read("tiles_state", node_tiles_->state()), gpu::read("nodes", nodes_),
                          gpu::read("state", state_), gpu::write("ranks", ranks_)});
    node_tiles_->dispatch(commands);
    rank_sum_->record(commands, ranks_, ranks_, {state_, SVO_STATE_LEVEL_NODES}, {state_, SVO_STATE_LEVEL_FLAGGED});
    commands.bind(allocate_, {gpu::read("tiles_state", node_tiles_->state()), gpu::read("state", state_),
                              gpu::read("ranks", ranks_), gpu::read_write("nodes", nodes_)});
    commands.push(push(level));
    node_tiles_->dispatch(commands);
    commands.bind(next_, {gpu::read_write("state", state_)});
    commands.push(push(level));
    commands.dispatch(1);
}

void SparseVoxelOctreeGpu::record_surfaces(gpu::CommandList& commands) {
    gpu::Buffer& counts = with_surfaces_ ? surfaces_ : ranks_;
    if (with_surfaces_) commands.fill(surfaces_, ~0u);
    node_tiles_->record(commands, {state_, SVO_STATE_BRICKS});
    commands.bind(count_voxels_, {gpu::read("tiles_state", node_tiles_->state()), gpu::read("bricks", bricks_),
                                  gpu::write("counts", counts)});
    node_tiles_->dispatch(commands);
    rank_sum_->record(commands, counts, counts, {state_, SVO_STATE_BRICKS}, {state_, SVO_STATE_VOXELS});
    if (!with_surfaces_) return;
    commands.bind(fill_surfaces_,
                  {gpu::read("tiles_state", fragment_tiles_->state()), gpu::read("fragments", fragments_),
                   gpu::read("nodes", nodes_), gpu::read("bricks", bricks_), gpu::read_write("surfaces", surfaces_)});
    commands.push(push(host_constants_.levels));
    fragment_tiles_->dispatch(commands);
}

void SparseVoxelOctreeGpu::record_build(gpu::CommandList& commands) {
    record_voxelise(commands);
    {
        const gpu::Scope scope(commands, "svo_build");
        commands.fill(bricks_, 0);
        commands.bind(begin_, {gpu::read_write("state", state_), gpu::read_write("nodes", nodes_)});
        commands.push(push(1));
        commands.dispatch(1);
        fragment_tiles_->record(commands, {state_, SVO_STATE_FRAGMENTS});
        for (uint32_t level = 1; level <= host_constants_.levels; ++level) record_level(commands, level);
        commands.bind(fill_masks_,
                      {gpu::read("tiles_state", fragment_tiles_->state()), gpu::read("fragments", fragments_),
                       gpu::read("nodes", nodes_), gpu::read_write("bricks", bricks_)});
        commands.push(push(host_constants_.levels));
        fragment_tiles_->dispatch(commands);
        record_surfaces(commands);
    }
    commands.copy(state_, 0, host_state_, 0, state_.bytes());
    commands.host_reads(host_state_);
}

bool SparseVoxelOctreeGpu::grow_if_short() {
    if (counted(SVO_STATE_COLUMNS_HIGH) > 0 || counted(SVO_STATE_COLUMNS_LOW) > kMostColumns)
        throw Error(ErrorCode::OutOfMemory, "the scene's triangles cross more than 2^31 columns of voxel bricks");
    const Room counted_room{fragment_count(), node_count(), brick_count(), voxel_count()};
    const bool short_of_nodes = counted_room.nodes > room_.nodes;
    const auto grown = [](uint64_t count, uint64_t room) { return count > room ? with_slack(count) : room; };
    // Where nodes were short, those below them have not been counted.
    Room room{grown(counted_room.fragments, room_.fragments),
              short_of_nodes ? std::max(2 * room_.nodes, with_slack(counted_room.nodes)) : room_.nodes,
              grown(counted_room.bricks, room_.bricks), grown(counted_room.voxels, room_.voxels)};
    const bool tree = short_of_nodes || room.bricks > room_.bricks || (with_surfaces_ && room.voxels > room_.voxels);
    const bool scratch = room.fragments > room_.fragments || short_of_nodes || room.bricks > room_.bricks;
    if (tree) make_tree(room);
    if (scratch) make_scratch(room);
    return tree || scratch;
}

void SparseVoxelOctreeGpu::trim() {
    const auto some = [](uint64_t count) { return std::max<uint64_t>(count, 1); };
    const Room exact{room_.fragments, node_count(), some(brick_count()), some(voxel_count())};
    gpu::Buffer nodes = std::move(nodes_), bricks = std::move(bricks_), surfaces = std::move(surfaces_);
    const uint64_t old_base = room_.bricks;
    make_tree(exact);
    gpu::CommandList commands(device_);
    commands.copy(nodes, 0, nodes_, 0, nodes_.bytes());
    commands.copy(bricks, 0, bricks_, 0, bricks_.bytes());
    if (with_surfaces_) {
        commands.copy(surfaces, 0, surfaces_, 0, exact.bricks * sizeof(uint32_t));
        commands.copy(surfaces, old_base * sizeof(uint32_t), surfaces_, exact.bricks * sizeof(uint32_t),
                      exact.voxels * sizeof(uint32_t));
    }
    commands.submit();
    commands.wait();
}

uint64_t SparseVoxelOctreeGpu::guess_device_bytes(uint32_t resolution, bool surfaces, uint64_t triangles) {
    constexpr double kSurface = 6.6, kBytesABrick = 85, kTriangleBytesABrick = 72, kBytesATriangle = 28;
    const double side = resolution / double{BRICK_SIDE};
    const double bricks = std::min(kSurface * side * side, side * side * side);
    return static_cast<uint64_t>(bricks * (kBytesABrick + (surfaces ? kTriangleBytesABrick : 0)) +
                                 kBytesATriangle * static_cast<double>(triangles));
}

void SparseVoxelOctreeGpu::build_now(Stats& stats) {
    while (true) {
        gpu::CommandList commands(device_);
        record_build(commands);
        commands.submit();
        commands.wait();
        commands.add_times(stats);
        if (!grow_if_short()) break;
    }
    trim();
}

uint64_t SparseVoxelOctreeGpu::device_bytes() const {
    return tree_bytes(room_, with_surfaces_) + constants_buffer_.bytes() + first_triangles_.bytes();
}

uint64_t SparseVoxelOctreeGpu::device_bytes_with_scratch() const {
    return device_bytes() + fragments_.bytes() + ranks_.bytes() + columns_.bytes() + state_.bytes();
}

}  // namespace photond
