#include "renderer/voxels/sparse_voxel_octree_gpu.h"

#include <bit>
#include <cstddef>

#include "renderer/scene/scene.h"
#include "renderer/voxels/sparse_voxel_octree.h"

namespace photond {

namespace {

constexpr uint64_t kMostNodes = 1ull << 30;
constexpr const char* kTree = "voxel_tree";
constexpr const char* kScratch = "voxel_fragments";

uint32_t word(uint64_t count) { return static_cast<uint32_t>(count); }
uint64_t with_slack(uint64_t count) { return count + count / 4; }
uint32_t levels_of(uint32_t resolution) { return word(std::countr_zero(resolution / BRICK_SIDE)); }
gpu::Buffer scratch_words(gpu::Device& device, uint64_t words) {
    return {device, kScratch, std::max<uint64_t>(words, 1) * sizeof(uint32_t)};
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
      constants_buffer_(device_, kTree, sizeof(gpu::SvoConstants)),
      host_state_(device_, "readback", sizeof(gpu::SvoBuildState), gpu::MemoryKind::Readback),
      count_columns_(device_, "renderer/voxels/voxel_columns.comp", 0, &scene.set(),
                     scene.specialization(shape_.constants())),
      make_fragments_(device_, "renderer/voxels/voxel_fragments.comp", sizeof(gpu::SvoBuildPush), &scene.set(),
                      scene.specialization()),
      rank_(device_, "renderer/voxels/svo_ranks.comp", sizeof(gpu::SvoBuildPush), nullptr, shape_.constants()),
      fill_(device_, "renderer/voxels/svo_fill.comp", sizeof(gpu::SvoBuildPush)),
      count_voxels_(device_, "renderer/voxels/svo_counts.comp", sizeof(gpu::SvoBuildPush), nullptr, shape_.constants()),
      fill_surfaces_(device_, "renderer/voxels/svo_surfaces.comp", sizeof(gpu::SvoBuildPush)) {
    const std::vector<uint32_t> first = first_triangles_of(scene.scene());
    first_triangles_ = gpu::make_buffer(device_, kTree, std::span(first));
    host_constants_.instance_count = word(scene.scene().instances.size());
    host_constants_.triangle_count = first.back();
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
}

void SparseVoxelOctreeGpu::make_tree(const Room& room) {
    if (room.nodes > kMostNodes) throw Error(ErrorCode::OutOfMemory, "the voxels' octree has more than 2^30 nodes");
    nodes_ = {}, bricks_ = {}, surfaces_ = {}, first_voxels_ = {}, voxel_starts_ = {};  // not both at once
    nodes_ = gpu::Buffer(device_, kTree, room.nodes * sizeof(gpu::SvoNode));
    bricks_ = gpu::Buffer(device_, kTree, room.bricks * sizeof(gpu::SvoBrick));
    const uint64_t surface_words = with_surfaces_ ? room.bricks + room.voxels : 1;
    surfaces_ = gpu::Buffer(device_, kTree, surface_words * sizeof(uint32_t));
    if (with_surfaces_) {
        first_voxels_ = scratch_words(device_, room.bricks);
        voxel_starts_ = scratch_words(device_, gpu::groups(room.bricks, shape_.threads()));
    }
    room_.nodes = room.nodes, room_.bricks = room.bricks, room_.voxels = room.voxels;
    write_constants();
}

void SparseVoxelOctreeGpu::make_fragment_room(uint64_t fragments) {
    fragments_ = {};
    fragments_ = gpu::Buffer(device_, kScratch, fragments * sizeof(gpu::SvoFragment));
    room_.fragments = fragments;
}

void SparseVoxelOctreeGpu::write_constants() {
    host_constants_.surface_base = with_surfaces_ ? word(room_.bricks) : 0;
    gpu::upload(device_, constants_buffer_, std::as_bytes(std::span(&host_constants_, 1)));
}

gpu::SvoBuildPush SparseVoxelOctreeGpu::push() const {
    return {.levels = host_constants_.levels,
            .words = words_of(host_constants_.levels),
            .sum_group = shape_.threads(),
            .fragment_capacity = word(room_.fragments),
            .node_capacity = word(room_.nodes),
            .brick_capacity = word(room_.bricks),
            .surface_base = host_constants_.surface_base};
}

void SparseVoxelOctreeGpu::record_voxelise(gpu::CommandList& commands) {
    const gpu::Scope scope(commands, "voxelise");
    commands.bind(count_columns_, {gpu::read_write("state", state_), gpu::read("constants", constants_buffer_),
                                   gpu::read("svo_first_triangles", first_triangles_), gpu::write("columns", columns_),
                                   gpu::read_write("group_starts", column_starts_), gpu::write("flags", flags_),
                                   gpu::write("bricks", bricks_), gpu::write("surfaces", surfaces_)});
    constexpr uint64_t kEmptiedBytesAThread = 64;
    const uint64_t emptying = (flags_.bytes() + bricks_.bytes() + surfaces_.bytes()) / kEmptiedBytesAThread + 1;
    const uint64_t counting =
        uint64_t{gpu::groups(host_constants_.triangle_count, shape_.threads())} * shape_.threads();
    commands.dispatch_threads(counting + emptying, shape_.threads());
    commands.bind(make_fragments_, {gpu::read_write("state", state_), gpu::read("constants", constants_buffer_),
                                    gpu::read("svo_first_triangles", first_triangles_), gpu::read("columns", columns_),
                                    gpu::read("column_starts", column_starts_), gpu::read_write("flags", flags_),
                                    gpu::write("fragments", fragments_)});
    commands.push(push());
    commands.dispatch_indirect(state_, offsetof(gpu::SvoBuildState, column_groups));
}

void SparseVoxelOctreeGpu::record_surfaces(gpu::CommandList& commands) {
    commands.bind(count_voxels_,
                  {gpu::read_write("state", state_), gpu::read("bricks", bricks_),
                   gpu::write("first_voxels", first_voxels_), gpu::read_write("group_starts", voxel_starts_)});
    commands.push(push());
    commands.dispatch_indirect(state_, offsetof(gpu::SvoBuildState, brick_groups));
    commands.bind(fill_surfaces_,
                  {gpu::read_write("state", state_), gpu::read("fragments", fragments_), gpu::read("flags", flags_),
                   gpu::read("ranks", ranks_), gpu::read("rank_starts", rank_starts_), gpu::read("bricks", bricks_),
                   gpu::read("first_voxels", first_voxels_), gpu::read("voxel_starts", voxel_starts_),
                   gpu::read_write("surfaces", surfaces_)});
    commands.push(push());
    commands.dispatch_indirect(state_, offsetof(gpu::SvoBuildState, surface_groups));
}

void SparseVoxelOctreeGpu::record_build(gpu::CommandList& commands) {
    record_voxelise(commands);
    {
        const gpu::Scope scope(commands, "svo_build");
        commands.bind(rank_, {gpu::read_write("state", state_), gpu::read("flags", flags_),
                              gpu::read_write("ranks", ranks_), gpu::read_write("group_starts", rank_starts_)});
        commands.push(push());
        commands.dispatch_threads(words_of(host_constants_.levels), shape_.threads());
        commands.bind(fill_,
                      {gpu::read_write("state", state_), gpu::read("fragments", fragments_), gpu::read("flags", flags_),
                       gpu::read("ranks", ranks_), gpu::read("rank_starts", rank_starts_), gpu::write("nodes", nodes_),
                       gpu::read_write("bricks", bricks_)});
        commands.push(push());
        commands.dispatch_indirect(state_, offsetof(gpu::SvoBuildState, fill_groups));
        if (with_surfaces_) record_surfaces(commands);
    }
    commands.copy(state_, 0, host_state_, 0, host_state_.bytes());
    commands.host_reads(host_state_);
}

bool SparseVoxelOctreeGpu::grow_if_short() {
    if (counted().columns > SVO_MOST_COLUMNS)
        throw Error(ErrorCode::OutOfMemory, "the scene's triangles cross more than 2^31 columns of voxel bricks");
    // Where fragments or bricks were short, voxels are more than were counted, and may be short the next time.
    const auto grown = [](uint64_t count, uint64_t room) { return count > room ? with_slack(count) : room; };
    const Room room{grown(fragment_count(), room_.fragments), grown(node_count(), room_.nodes),
                    grown(brick_count(), room_.bricks), grown(voxel_count(), room_.voxels)};
    const bool tree =
        room.nodes > room_.nodes || room.bricks > room_.bricks || (with_surfaces_ && room.voxels > room_.voxels);
    const bool fragments = room.fragments > room_.fragments;
    if (tree) make_tree(room);
    if (fragments) make_fragment_room(room.fragments);
    return tree || fragments;
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
    constexpr double kSurface = 6.6, kBytesABrick = 70, kTriangleBytesABrick = 77, kBytesATriangle = 28;
    const double side = resolution / double{BRICK_SIDE};
    const double bricks = std::min(kSurface * side * side, side * side * side);
    return scratch_bytes({}, resolution, surfaces) +
           static_cast<uint64_t>(bricks * (kBytesABrick + (surfaces ? kTriangleBytesABrick : 0)) +
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
    uint64_t bytes = device_bytes();
    for (const gpu::Buffer* scratch : {&state_, &columns_, &column_starts_, &fragments_, &flags_, &ranks_,
                                       &rank_starts_, &first_voxels_, &voxel_starts_})
        bytes += scratch->bytes();
    return bytes;
}

}  // namespace photond
