#pragma once
// SparseVoxelOctree made on a device. What it takes is mostly the number of passes that wait for each other, so that
// there are four (with surfaces, six), however many levels the tree has: columns, fragments, ranks, and the tree.
// Departures from the thesis (4.3): the tree is not made level by level, but at once from bits that say which nodes of
// all levels fragments lie in; tiles are allocated by prefix sums over these instead of an atomic counter, so that the
// arrays are the CPU's bit for bit; triangles are cut into columns of bricks instead of rasterised, so that a wall and
// a crumb load the device evenly and no voxel is missed.
//
// Where little moves, the bricks of what does not can be kept, and a tree follows from them: its nodes are those of the
// kept bricks and of the fragments of what moves, and each brick begins as the kept one. A voxel's triangle is the
// least of leasts, so that the tree has the bits of one that is built anew.

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer/backends/gpu/command_list.h"
#include "renderer/backends/gpu/device_scene.h"
#include "renderer/backends/gpu/group_sum.h"
#include "renderer/voxels/svo_build_shared.h"
#include "renderer/voxels/voxel_grid.h"

namespace photond {

class SparseVoxelOctreeGpu {
public:
    /// Borrows the scene. Builds nothing yet; room is made by what its triangles' sizes let expect.
    SparseVoxelOctreeGpu(const gpu::DeviceScene& scene, const VoxelGrid& grid, bool surfaces);

    /// On the device, at first: of the tree and of what building it takes.
    static uint64_t estimate_device_bytes(const Scene& scene, const VoxelGrid& grid, bool surfaces);

    /// The same where nothing is known of the scene but that it has rooms, and triangles: walls of some times the
    /// cube's side.
    static uint64_t guess_device_bytes(uint32_t resolution, bool surfaces, uint64_t triangles);

    /// Builds, waits, makes room until there is enough, and gives back what is more than enough; `will_change`: what is
    /// more than a quarter more. Stages `voxelise` and `svo_build`.
    void build_now(Stats& stats, bool will_change = false);
    /// Builds anew within a frame, without a wait; scopes `voxelise` and `svo_build`. Once that has been waited for,
    /// grow_if_short() says whether the room that build_now() made was enough.
    void record_build(gpu::CommandList& commands);
    /// Once a recorded build has been waited for: true where there was too little room, and the tree empty. Now there
    /// is more, and it must be built again, and asked again. Throws ErrorCode::OutOfMemory where the device cannot hold
    /// it.
    bool grow_if_short();

    /// Begins to build anew, in the room that there is, without a wait: whoever asks next finds the tree. Nothing else
    /// of it is called before settle() but what shaders ask for, room() and bytes.
    void start_rebuild();
    /// Begins to make the tree of what is kept and of these instances, rising numbers, as they are now. Else as
    /// start_rebuild(); stages `voxelise` and `svo_update`.
    void start_update(std::span<const uint32_t> instances);
    /// Waits for what was begun; nothing where nothing was, or it was waited for before. True: there was too little
    /// room and the tree empty, so that whoever asked must ask again. Now it is whole. Throws as grow_if_short().
    bool settle(Stats& stats);

    /// Keeps the bricks of these instances, rising numbers, as they are now, which leaves no tree: start_update()
    /// must come. Waits. Of a tree like the last one it takes most_kept_bytes().
    void keep(std::span<const uint32_t> instances, Stats& stats);
    uint64_t most_kept_bytes() const;
    bool keeps() const { return kept_.has_value(); }
    void keep_nothing();

    /// Whether it may be built again for this, as the scene is now.
    bool is_of(const gpu::DeviceScene& scene, const VoxelGrid& grid, bool surfaces) const;
    gpu::Device& device() const { return device_; }

    // For shaders that include svo_march.glsl. They stay the same until grow_if_short() or settle() says true, or it is
    // built now.
    gpu::Buffer& constants() { return constants_buffer_; }
    gpu::Buffer& nodes() { return nodes_; }
    gpu::Buffer& bricks() { return bricks_; }
    gpu::Buffer& surfaces() { return surfaces_; }                // a word without surfaces
    gpu::Buffer& first_triangles() { return first_triangles_; }  // for svo_hit.glsl

    const gpu::SvoConstants& host_constants() const { return host_constants_; }
    /// What there is room for.
    struct Room {
        uint64_t fragments, nodes, bricks, voxels;
    };
    const Room& room() const { return room_; }
    // Of the last build waited for.
    uint64_t fragment_count() const { return counted().fragments; }
    uint64_t node_count() const { return counted().nodes; }
    uint64_t brick_count() const { return counted().bricks; }
    uint64_t voxel_count() const { return counted().voxels; }

    /// Of the tree itself, and with what building it takes and what is kept.
    uint64_t device_bytes() const;
    uint64_t device_bytes_with_scratch() const;
    std::map<std::string, uint64_t> structures() const;  // with what building takes and what is kept
    /// device_bytes() over set voxels.
    double bytes_a_voxel() const { return double(device_bytes()) / double(std::max<uint64_t>(voxel_count(), 1)); }

private:
    /// Of a tree of what does not move, all but its nodes.
    struct Kept {
        gpu::Buffer flags, ranks, rank_starts, bricks, surfaces;
        uint32_t brick_count, voxel_count;
    };
    struct KeptPasses {
        explicit KeptPasses(gpu::Device& device);
        gpu::ComputePipeline tiles, surfaces;
    };
    static Room expected_room(const Scene& scene, const VoxelGrid& grid);
    static uint64_t tree_bytes(const Room& room, bool surfaces);
    static uint64_t scratch_bytes(const Room& room, uint32_t resolution, bool surfaces);
    const gpu::SvoBuildState& counted() const { return host_state_.as<gpu::SvoBuildState>()[0]; }
    gpu::SvoBuildPush push(bool follows) const;
    void ask(std::span<const uint32_t> instances);
    void ask_all();
    void start(bool follows);
    void make_tree(const Room& room);
    void make_fragment_room(uint64_t fragments);
    void trim(bool slack);
    std::vector<const gpu::Buffer*> buffers() const;
    void record(gpu::CommandList& commands, bool follows);
    void record_voxelise(gpu::CommandList& commands, bool follows);
    void record_kept_tiles(gpu::CommandList& commands);
    void record_surfaces(gpu::CommandList& commands, bool follows);

    gpu::Device& device_;
    const gpu::DeviceScene& scene_;
    const bool with_surfaces_;
    const gpu::GroupShape shape_;
    gpu::SvoConstants host_constants_;
    const std::vector<gpu::Specialization> scene_constants_;
    const std::vector<uint32_t> host_first_triangles_;
    std::vector<uint32_t> asked_instances_;
    uint32_t asked_triangles_ = 0;
    Room room_{};
    std::optional<Kept> kept_;
    gpu::Buffer constants_buffer_, nodes_, bricks_, surfaces_, first_triangles_;
    gpu::Buffer state_, host_state_, columns_, column_starts_, fragments_, flags_, ranks_, rank_starts_, first_voxels_,
        voxel_starts_, asked_, kept_places_;
    gpu::ComputePipeline count_columns_, make_fragments_, rank_, fill_, count_voxels_, fill_surfaces_;
    std::optional<KeptPasses> kept_passes_;  // once something is kept
    struct UnderWay {
        gpu::CommandList commands;
        bool follows;
    };
    std::unique_ptr<UnderWay> under_way_;  // last: its going waits for work that uses the others
};

}  // namespace photond
