#include "renderer/methods/voxel_cone_tracing/cone_tree_gpu.h"

#include <algorithm>
#include <bit>

#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr const char* kConeTree = "cone_tree";

std::string cone_shader(const char* name) { return "renderer/methods/voxel_cone_tracing/" + std::string(name); }

uint64_t table_words(uint32_t levels) {
    uint64_t words = 0;
    for (uint32_t level = 1; level <= levels; ++level) words = 8 * (words + 1);
    return words;
}

}  // namespace

gpu::ConeTreeConstants ConeTreeGpu::constants() const {
    const auto voxels = static_cast<uint32_t>(tree_->room().voxels),
               bricks = static_cast<uint32_t>(tree_->room().bricks);
    const uint32_t levels = tree_->host_constants().levels;
    return {.levels = levels,
            .first_half = voxels,
            .first_brick = voxels + 8 * bricks,
            .first_node = voxels + 9 * bricks,
            .table_words = static_cast<uint32_t>(table_words(levels)),
            .voxels = voxels};
}

ConeTreeGpu::ConeTreeGpu(const gpu::DeviceScene& scene, const VoxelGrid& grid, uint32_t most, Stats& stats,
                         KeptVoxels* kept)
    : scene_(scene),
      most_(most),
      tree_(kept, scene, grid, true, stats),
      light_voxels_(scene.device(), cone_shader("cone_leaves.comp"), 0),
      filter_(scene.device(), cone_shader("cone_filter.comp"), sizeof(gpu::ConeFilterPush)) {
    make_cells(stats);
}

void ConeTreeGpu::make_cells(Stats& stats) {
    gpu::Device& device = scene_.device();
    by_voxel_.reset(), table_ = {}, cells_ = {};  // not both at once
    host_constants_ = constants();
    constants_ = gpu::make_buffer(device, kConeTree, std::span<const gpu::ConeTreeConstants>(&host_constants_, 1));
    table_ = gpu::Buffer(device, kConeTree, host_constants_.table_words * sizeof(uint32_t));
    cells_ =
        gpu::Buffer(device, kConeTree,
                    (host_constants_.first_node + std::max<uint64_t>(tree_->room().nodes, 1)) * sizeof(gpu::ConeCell));
    by_voxel_.emplace(scene_, most_, host_constants_.voxels, cone_shader("cone_keys.comp"), 0u);
    find_places(stats);
}

bool ConeTreeGpu::settle(Stats& stats) {
    const bool was_short = tree_.settle(stats);
    if (was_short) make_cells(stats);
    return was_short;
}

uint64_t ConeTreeGpu::guess_device_bytes(uint32_t resolution, uint32_t most, uint64_t triangles) {
    constexpr double kSurface = 6.6, kCellsABrick = 16 + 9 + 2;  // its voxels, eights and itself, and nodes above
    const double side = resolution / double{BRICK_SIDE}, bricks = std::min(kSurface * side * side, side * side * side);
    return SparseVoxelOctreeGpu::guess_device_bytes(resolution, true, triangles) +
           PhotonsByCellGpu::device_bytes(most) +
           table_words(static_cast<uint32_t>(std::countr_zero(resolution)) - 2) * sizeof(uint32_t) +
           static_cast<uint64_t>(bricks * kCellsABrick) * sizeof(gpu::ConeCell);
}

void ConeTreeGpu::append_to(std::vector<gpu::Binding>& bindings) {
    bindings.insert(bindings.end(),
                    {gpu::read("svo_constants", tree_->constants()), gpu::read("svo_bricks", tree_->bricks()),
                     gpu::read("svo_surfaces", tree_->surfaces()), gpu::read("cone_tree", constants_),
                     gpu::read("cone_table", table_)});
}

void ConeTreeGpu::append_lit_to(std::vector<gpu::Binding>& bindings) {
    append_to(bindings);
    bindings.push_back(gpu::read("cone_cells", cells_));
}

void ConeTreeGpu::find_places(Stats& stats) {
    gpu::Device& device = scene_.device();
    const auto bricks = static_cast<uint32_t>(tree_->room().bricks);
    const gpu::ComputePipeline find_cells(device, cone_shader("cone_table.comp"), 0);
    const gpu::ComputePipeline find_bricks(device, cone_shader("cone_places.comp"), 0);
    const gpu::ComputePipeline cover(device, cone_shader("cone_cover.comp"), sizeof(gpu::ConeCoverPush), &scene_.set(),
                                     scene_.specialization());
    gpu::Buffer places(device, kConeTree, std::max<uint64_t>(bricks, 1) * sizeof(uvec3));
    gpu::CommandList commands(device);
    {
        const gpu::Scope scope(commands, "svo_build");
        commands.fill(cells_, 0);
        commands.fill(places, NO_CONE_CELL);
        commands.bind(find_cells, {gpu::read("cone_tree", constants_), gpu::read("svo_nodes", tree_->nodes()),
                                   gpu::write("cone_table", table_)});
        commands.dispatch_threads(host_constants_.table_words, CONE_GROUP);
        commands.bind(find_bricks, {gpu::read("cone_tree", constants_), gpu::read("cone_table", table_),
                                    gpu::write("brick_places", places)});
        commands.dispatch_threads(uint64_t{1} << 3 * host_constants_.levels, CONE_GROUP);
    }
    constexpr uint64_t kRaysAPath = 8, kRaysABrick = 16 * 3 * COVER_RAYS_SIDE * COVER_RAYS_SIDE;
    const auto at_once = static_cast<uint32_t>(kRaysAPath * device.paths_per_submit() / kRaysABrick + 1);
    for (uint32_t first = 0; first < bricks; first += at_once) {
        const uint32_t end = std::min(first + at_once, bricks);
        {
            const gpu::Scope scope(commands, "voxelise");
            std::vector<gpu::Binding> bindings = {gpu::read("brick_places", places), gpu::write("cone_cells", cells_)};
            append_to(bindings);
            commands.bind(cover, bindings);
            commands.push(gpu::ConeCoverPush{first, end});
            commands.dispatch_threads(uint64_t{end - first} * CONE_GROUP, CONE_GROUP);
        }
        commands.submit();
        commands.wait();
        commands.add_times(stats);
        commands.reset();
    }
}

void ConeTreeGpu::record(gpu::CommandList& commands, VplTracerGpu& photons) {
    std::vector<gpu::Binding> tree;
    append_to(tree);
    {
        const gpu::Scope scope(commands, "inject");
        std::vector<gpu::Binding> bindings;
        append_lit_to(bindings);
        by_voxel_->record(commands, photons, bindings);
        bindings = tree;
        bindings.push_back(gpu::read_write("cone_cells", cells_));
        by_voxel_->append_to(bindings, photons);
        commands.bind(light_voxels_, bindings);
        commands.dispatch_threads(host_constants_.voxels, CONE_GROUP);
    }
    const gpu::Scope scope(commands, "filter_up");
    const uint32_t bits = host_constants_.levels + 2;  // of a voxel's place along an axis
    for (uint32_t mip = 1; mip < bits; ++mip) {
        std::vector<gpu::Binding> bindings = tree;
        bindings.push_back(gpu::read_write("cone_cells", cells_));
        commands.bind(filter_, bindings);
        commands.push(gpu::ConeFilterPush{mip});
        commands.dispatch_threads(uint64_t{1} << 3 * (bits - mip), CONE_GROUP);
    }
}

}  // namespace photond
