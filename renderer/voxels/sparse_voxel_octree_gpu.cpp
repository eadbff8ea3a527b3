#include "renderer/voxels/sparse_voxel_octree_gpu.h"

#include <bit>
#include <cstddef>
#include <numeric>

#include "renderer/scene/scene.h"
#include "renderer/voxels/sparse_voxel_octree.h"

namespace photond {

namespace {

constexpr uint64_t kMostNodes = 1ull << 30;
constexpr const char* kTree = "voxel_tree";
constexpr const char* kScratch = "voxel_fragments";
constexpr const char* kKept = "kept_voxels";

uint32_t word(uint64_t count) { return static_cast<uint32_t>(count); }
uint64_t with_slack(uint64_t count) { return count + count / 4; }
uint32_t levels_of(uint32_t resolution) { return word(std::countr_zero(resolution / BRICK_SIDE)); }
gpu::Buffer scratch_words(gpu::Device& device, uint64_t words) {
    return {device, kScratch, std::max<uint64_t>(words, 1) * sizeof(uint32_t)};
}
gpu::Buffer copy_of(gpu::Device& device, gpu::CommandList& commands, gpu::Buffer& from, uint64_t bytes) {
    gpu::Buffer copy(device, kKept, std::max<uint64_t>(bytes, sizeof(uint32_t)));
    if (bytes > 0) commands.copy(from, 0, copy, 0, bytes);
    return copy;
}
/// Of the bits that say which nodes are flagged.
uint32_t words_of(uint32_t levels) { return SVO_FIRST_WORD(levels + 1); }

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

uint64_t SparseVoxelOctreeGpu::scratch_bytes(const Room& room, uint32_t resolution, bool surfaces) {
    return room.fragments * sizeof(gpu::SvoFragment) + (surfaces ? room.bricks * sizeof(uint32_t) : 0) +
           2 * sizeof(uint32_t) * words_of(levels_of(resolution));
}

uint64_t SparseVoxelOctreeGpu::estimate_device_bytes(const Scene& scene, const VoxelGrid& grid, bool surfaces) {
    const Room room = expected_room(scene, grid);
    return tree_bytes(room, surfaces) + scratch_bytes(room, grid.resolution, surfaces) +
           (scene.triangle_count + scene.instances.size()) * sizeof(uint32_t);
}

SparseVoxelOctreeGpu::SparseVoxelOctreeGpu(const gpu::DeviceScene& scene, const VoxelGrid& grid, bool surfaces)
    : device_(scene.device()),
      scene_(scene),
      with_surfaces_(surfaces),
      shape_(device_),
      host_constants_(svo_constants_of(grid)),
      scene_constants_(scene.specialization().begin(), scene.specialization().end()),
      host_first_triangles_(first_triangles_of(scene.scene())),
      constants_buffer_(device_, kTree, sizeof(gpu::SvoConstants)),
      host_state_(device_, "readback", sizeof(gpu::SvoBuildState), gpu::MemoryKind::Readback),
      count_columns_(device_, "renderer/voxels/voxel_columns.comp", sizeof(gpu::SvoBuildPush), &scene.set(),
                     scene.specialization(shape_.constants())),
      make_fragments_(device_, "renderer/voxels/voxel_fragments.comp", sizeof(gpu::SvoBuildPush), &scene.set(),
                      scene.specialization()),
      rank_(device_, "renderer/voxels/svo_ranks.comp", sizeof(gpu::SvoBuildPush), nullptr, shape_.constants()),
      fill_(device_, "renderer/voxels/svo_fill.comp", sizeof(gpu::SvoBuildPush)),
      count_voxels_(device_, "renderer/voxels/svo_counts.comp", sizeof(gpu::SvoBuildPush), nullptr, shape_.constants()),
      fill_surfaces_(device_, "renderer/voxels/svo_surfaces.comp", sizeof(gpu::SvoBuildPush)) {
    first_triangles_ = gpu::make_buffer(device_, kTree, std::span(host_first_triangles_));
    host_constants_.instance_count = word(scene.scene().instances.size());
    host_constants_.triangle_count = host_first_triangles_.back();
    gpu::upload(device_, constants_buffer_, std::as_bytes(std::span(&host_constants_, 1)));
    const gpu::SvoBuildState none{};
    state_ = gpu::make_buffer(device_, kScratch, std::span(&none, 1));
    columns_ = scratch_words(device_, host_constants_.triangle_count);
    column_starts_ = scratch_words(device_, gpu::groups(host_constants_.triangle_count, shape_.threads()));
    const uint32_t words = words_of(host_constants_.levels);
    flags_ = scratch_words(device_, words);
    ranks_ = scratch_words(device_, words);
    rank_starts_ = scratch_words(device_, gpu::groups(words, shape_.threads()));
    const Room room = expected_room(scene.scene(), grid);
    make_tree(room);
    make_fragment_room(room.fragments);
    ask_all();
}

void SparseVoxelOctreeGpu::make_tree(const Room& room) {
    if (room.nodes > kMostNodes) throw Error(ErrorCode::OutOfMemory, "the voxels' octree has more than 2^30 nodes");
    nodes_ = {}, bricks_ = {}, surfaces_ = {}, first_voxels_ = {}, voxel_starts_ = {},
    kept_places_ = {};  // not both at once
    nodes_ = gpu::Buffer(device_, kTree, room.nodes * sizeof(gpu::SvoNode));
    bricks_ = gpu::Buffer(device_, kTree, room.bricks * sizeof(gpu::SvoBrick));
    const uint64_t surface_words = with_surfaces_ ? room.bricks + room.voxels : 1;
    surfaces_ = gpu::Buffer(device_, kTree, surface_words * sizeof(uint32_t));
    if (with_surfaces_) {
        first_voxels_ = scratch_words(device_, room.bricks);
        voxel_starts_ = scratch_words(device_, gpu::groups(room.bricks, shape_.threads()));
    }
    if (kept_) kept_places_ = scratch_words(device_, room.bricks);
    room_.nodes = room.nodes, room_.bricks = room.bricks, room_.voxels = room.voxels;
}

void SparseVoxelOctreeGpu::make_fragment_room(uint64_t fragments) {
    fragments_ = {};
    fragments_ = gpu::Buffer(device_, kScratch, fragments * sizeof(gpu::SvoFragment));
    room_.fragments = fragments;
}

void SparseVoxelOctreeGpu::ask(std::span<const uint32_t> instances) {
    if (asked_ && std::ranges::equal(instances, asked_instances_)) return;
    asked_instances_.assign(instances.begin(), instances.end());
    asked_triangles_ = 0;
    std::vector<gpu::SvoAskedInstance> asked;
    for (const uint32_t instance : instances) {
        const uint32_t first = host_first_triangles_[instance];
        asked.push_back({asked_triangles_, instance, first});
        asked_triangles_ += host_first_triangles_[instance + 1] - first;
    }
    asked_ = {};
    asked_ = gpu::make_buffer(device_, kScratch, std::span<const gpu::SvoAskedInstance>(asked));
}

void SparseVoxelOctreeGpu::ask_all() {
    std::vector<uint32_t> all(host_constants_.instance_count);
    std::iota(all.begin(), all.end(), 0u);
    ask(all);
}

gpu::SvoBuildPush SparseVoxelOctreeGpu::push(bool follows) const {
    return {.levels = host_constants_.levels,
            .words = words_of(host_constants_.levels),
            .sum_group = shape_.threads(),
            .fragment_capacity = word(room_.fragments),
            .node_capacity = word(room_.nodes),
            .brick_capacity = word(room_.bricks),
            .voxel_capacity = word(room_.voxels),
            .surfaces = with_surfaces_,
            .asked = word(asked_instances_.size()),
            .asked_triangles = asked_triangles_,
            .follows = follows,
            .kept_voxels = follows ? kept_->voxel_count : 0,
            .kept_bricks = follows ? kept_->brick_count : 0};
}

void SparseVoxelOctreeGpu::record_voxelise(gpu::CommandList& commands, bool follows) {
    const gpu::Scope scope(commands, "voxelise");
    if (follows) commands.copy(kept_->flags, 0, flags_, 0, flags_.bytes());
    commands.bind(count_columns_, {gpu::read_write("state", state_), gpu::read("constants", constants_buffer_),
                                   gpu::read("asked", asked_), gpu::write("columns", columns_),
                                   gpu::read_write("group_starts", column_starts_), gpu::write("flags", flags_),
                                   gpu::write("bricks", bricks_), gpu::write("surfaces", surfaces_)});
    commands.push(push(follows));
    constexpr uint64_t kEmptiedBytesAThread = 64;
    const uint64_t emptying =
        follows ? 0 : (flags_.bytes() + bricks_.bytes() + surfaces_.bytes()) / kEmptiedBytesAThread + 1;
    const uint64_t counting =
        uint64_t{std::max(gpu::groups(asked_triangles_, shape_.threads()), 1u)} * shape_.threads();
    commands.dispatch_threads(counting + emptying, shape_.threads());
    commands.bind(make_fragments_, {gpu::read_write("state", state_), gpu::read("constants", constants_buffer_),
                                    gpu::read("asked", asked_), gpu::read("columns", columns_),
                                    gpu::read("column_starts", column_starts_), gpu::read_write("flags", flags_),
                                    gpu::write("fragments", fragments_)});
    commands.push(push(follows));
    commands.dispatch_indirect(state_, offsetof(gpu::SvoBuildState, column_groups));
}

void SparseVoxelOctreeGpu::record_kept_tiles(gpu::CommandList& commands) {
    commands.bind(kept_passes_->tiles,
                  {gpu::read_write("state", state_), gpu::read("flags", flags_), gpu::read("ranks", ranks_),
                   gpu::read("rank_starts", rank_starts_), gpu::write("nodes", nodes_), gpu::write("bricks", bricks_),
                   gpu::read("kept_flags", kept_->flags), gpu::read("kept_ranks", kept_->ranks),
                   gpu::read("kept_rank_starts", kept_->rank_starts), gpu::read("kept_bricks", kept_->bricks),
                   gpu::write("kept_places", kept_places_)});
    commands.push(push(true));
    commands.dispatch_threads(uint64_t{32} * SVO_FIRST_WORD(host_constants_.levels), SVO_GROUP);
}

void SparseVoxelOctreeGpu::record_surfaces(gpu::CommandList& commands, bool follows) {
    commands.bind(count_voxels_,
                  {gpu::read_write("state", state_), gpu::read("bricks", bricks_),
                   gpu::write("first_voxels", first_voxels_), gpu::read_write("group_starts", voxel_starts_)});
    commands.push(push(follows));
    commands.dispatch_indirect(state_, offsetof(gpu::SvoBuildState, brick_groups));
    const std::vector<gpu::Binding> bindings = {
        gpu::read_write("state", state_), gpu::read("bricks", bricks_), gpu::read("first_voxels", first_voxels_),
        gpu::read("voxel_starts", voxel_starts_), gpu::read_write("surfaces", surfaces_)};
    if (follows) {
        std::vector<gpu::Binding> kept = bindings;
        kept.insert(kept.end(), {gpu::read("kept_bricks", kept_->bricks), gpu::read("kept_surfaces", kept_->surfaces),
                                 gpu::read("kept_places", kept_places_)});
        commands.bind(kept_passes_->surfaces, kept);
        commands.push(push(follows));
        commands.dispatch_indirect(state_, offsetof(gpu::SvoBuildState, kept_groups));
    }
    std::vector<gpu::Binding> adding = bindings;
    adding.insert(adding.end(),
                  {gpu::read("fragments", fragments_), gpu::read("flags", flags_), gpu::read("ranks", ranks_),
                   gpu::read("rank_starts", rank_starts_), gpu::write("nodes", nodes_)});
    commands.bind(fill_surfaces_, adding);
    commands.push(push(follows));
    commands.dispatch_indirect(state_, offsetof(gpu::SvoBuildState, surface_groups));
}

void SparseVoxelOctreeGpu::record_build(gpu::CommandList& commands) { record(commands, false); }

void SparseVoxelOctreeGpu::record(gpu::CommandList& commands, bool follows) {
    record_voxelise(commands, follows);
    {
        const gpu::Scope scope(commands, follows ? "svo_update" : "svo_build");
        commands.bind(rank_,
                      {gpu::read_write("state", state_), gpu::read("flags", flags_), gpu::read_write("ranks", ranks_),
                       gpu::read_write("group_starts", rank_starts_), gpu::write("constants", constants_buffer_)});
        commands.push(push(follows));
        commands.dispatch_threads(words_of(host_constants_.levels), shape_.threads());
        if (follows) record_kept_tiles(commands);
        commands.bind(fill_,
                      {gpu::read_write("state", state_), gpu::read("fragments", fragments_), gpu::read("flags", flags_),
                       gpu::read("ranks", ranks_), gpu::read("rank_starts", rank_starts_), gpu::write("nodes", nodes_),
                       gpu::read_write("bricks", bricks_)});
        commands.push(push(follows));
        commands.dispatch_indirect(state_, offsetof(gpu::SvoBuildState, fill_groups));
        if (with_surfaces_) record_surfaces(commands, follows);
    }
    commands.copy(state_, 0, host_state_, 0, host_state_.bytes());
    commands.host_reads(host_state_);
}

bool SparseVoxelOctreeGpu::grow_if_short() {
    if (counted().columns > SVO_MOST_COLUMNS)
        throw Error(ErrorCode::OutOfMemory, "the scene's triangles cross more than 2^31 columns of voxel bricks");
    // Where fragments or bricks were short, voxels are more than were counted, and may be short the next time.
    const bool tree =
        node_count() > room_.nodes || brick_count() > room_.bricks || (with_surfaces_ && voxel_count() > room_.voxels);
    const bool fragments = fragment_count() > room_.fragments;
    const auto grown = [](uint64_t count, uint64_t room) { return std::max(with_slack(count), room); };
    if (tree)
        make_tree({0, grown(node_count(), room_.nodes), grown(brick_count(), room_.bricks),
                   grown(voxel_count(), room_.voxels)});
    if (fragments) make_fragment_room(with_slack(fragment_count()));
    if (!tree && !fragments) host_constants_.surface_base = with_surfaces_ ? word(brick_count()) : 0;
    return tree || fragments;
}

void SparseVoxelOctreeGpu::trim(bool slack) {
    const auto some = [&](uint64_t count) { return std::max<uint64_t>(slack ? with_slack(count) : count, 1); };
    const Room left{room_.fragments, some(node_count()), some(brick_count()), some(voxel_count())};
    gpu::Buffer nodes = std::move(nodes_), bricks = std::move(bricks_), surfaces = std::move(surfaces_);
    make_tree(left);
    gpu::CommandList commands(device_);
    commands.copy(nodes, 0, nodes_, 0, node_count() * sizeof(gpu::SvoNode));
    if (brick_count() > 0) commands.copy(bricks, 0, bricks_, 0, brick_count() * sizeof(gpu::SvoBrick));
    if (with_surfaces_ && brick_count() > 0)
        commands.copy(surfaces, 0, surfaces_, 0, (brick_count() + voxel_count()) * sizeof(uint32_t));
    commands.submit();
    commands.wait();
}

uint64_t SparseVoxelOctreeGpu::guess_device_bytes(uint32_t resolution, bool surfaces, uint64_t triangles) {
    constexpr double kSurface = 6.6, kBytesABrick = 70, kTriangleBytesABrick = 77, kBytesATriangle = 28;
    const double side = resolution / double{BRICK_SIDE};
    const double bricks = std::min(kSurface * side * side, side * side * side);
    return scratch_bytes({}, resolution, surfaces) +
           static_cast<uint64_t>(bricks * (kBytesABrick + (surfaces ? kTriangleBytesABrick : 0)) +
                                 kBytesATriangle * static_cast<double>(triangles));
}

void SparseVoxelOctreeGpu::start(bool follows) {
    under_way_.reset();
    under_way_.reset(new UnderWay{gpu::CommandList(device_), follows});
    record(under_way_->commands, follows);
    under_way_->commands.submit();
}

bool SparseVoxelOctreeGpu::settle(Stats& stats) {
    bool grew = false;
    while (under_way_) {
        under_way_->commands.wait();
        under_way_->commands.add_times(stats);
        const std::unique_ptr<UnderWay> done = std::move(under_way_);
        if (!grow_if_short()) break;
        grew = true;
        start(done->follows);
    }
    return grew;
}

void SparseVoxelOctreeGpu::start_rebuild() {
    ask_all();
    start(false);
}

void SparseVoxelOctreeGpu::build_now(Stats& stats, bool will_change) {
    start_rebuild();
    settle(stats);
    trim(will_change);
}

SparseVoxelOctreeGpu::KeptPasses::KeptPasses(gpu::Device& device)
    : tiles(device, "renderer/voxels/svo_kept_tiles.comp", sizeof(gpu::SvoBuildPush)),
      surfaces(device, "renderer/voxels/svo_kept_surfaces.comp", sizeof(gpu::SvoBuildPush)) {}

void SparseVoxelOctreeGpu::keep_nothing() { kept_.reset(), kept_places_ = {}; }

void SparseVoxelOctreeGpu::keep(std::span<const uint32_t> instances, Stats& stats) {
    keep_nothing();
    ask(instances);
    start(false);
    settle(stats);
    if (!kept_passes_) kept_passes_.emplace(device_);
    const uint64_t bricks = brick_count(), voxels = voxel_count();
    gpu::CommandList commands(device_);
    const auto copy = [&](gpu::Buffer& from, uint64_t bytes) { return copy_of(device_, commands, from, bytes); };
    Kept kept{.flags = copy(flags_, flags_.bytes()),
              .ranks = copy(ranks_, ranks_.bytes()),
              .rank_starts = copy(rank_starts_, rank_starts_.bytes()),
              .bricks = copy(bricks_, bricks * sizeof(gpu::SvoBrick)),
              .surfaces = copy(surfaces_, with_surfaces_ ? (bricks + voxels) * sizeof(uint32_t) : 0),
              .brick_count = word(bricks),
              .voxel_count = word(voxels)};
    commands.submit();
    commands.wait();
    kept_places_ = scratch_words(device_, room_.bricks);
    kept_ = std::move(kept);
}

void SparseVoxelOctreeGpu::start_update(std::span<const uint32_t> instances) {
    ask(instances);
    start(true);
}

uint64_t SparseVoxelOctreeGpu::device_bytes() const {
    return tree_bytes(room_, with_surfaces_) + constants_buffer_.bytes() + first_triangles_.bytes();
}

uint64_t SparseVoxelOctreeGpu::most_kept_bytes() const {
    return device_bytes() + 3 * flags_.bytes() + room_.bricks * sizeof(uint32_t);
}

std::vector<const gpu::Buffer*> SparseVoxelOctreeGpu::buffers() const {
    std::vector<const gpu::Buffer*> buffers = {&constants_buffer_, &nodes_,        &bricks_,  &surfaces_,
                                               &first_triangles_,  &state_,        &columns_, &column_starts_,
                                               &fragments_,        &flags_,        &ranks_,   &rank_starts_,
                                               &first_voxels_,     &voxel_starts_, &asked_,   &kept_places_};
    if (kept_)
        for (const gpu::Buffer* kept :
             {&kept_->flags, &kept_->ranks, &kept_->rank_starts, &kept_->bricks, &kept_->surfaces})
            buffers.push_back(kept);
    return buffers;
}

uint64_t SparseVoxelOctreeGpu::device_bytes_with_scratch() const {
    uint64_t bytes = 0;
    for (const gpu::Buffer* buffer : buffers()) bytes += buffer->bytes();
    return bytes;
}

std::map<std::string, uint64_t> SparseVoxelOctreeGpu::structures() const {
    std::map<std::string, uint64_t> structures{{host_state_.structure(), host_state_.memory_bytes()}};
    for (const gpu::Buffer* buffer : buffers()) structures[buffer->structure()] += buffer->memory_bytes();
    structures.erase("");  // of those that hold nothing
    return structures;
}

bool SparseVoxelOctreeGpu::is_of(const gpu::DeviceScene& scene, const VoxelGrid& grid, bool surfaces) const {
    const auto same = [](const gpu::Specialization& a, const gpu::Specialization& b) {
        return a.id == b.id && a.value == b.value;
    };
    return &scene == &scene_ && same_grid(host_constants_.grid, grid) && surfaces == with_surfaces_ &&
           first_triangles_of(scene.scene()) == host_first_triangles_ &&
           std::ranges::equal(scene.specialization(), scene_constants_, same);
}

}  // namespace photond
