#pragma once
// HashGrid on a device: its cells, and sorting photons into them.

#include "renderer/photons/hash_grid_shared.h"
#include "renderer/photons/photon_tracer_gpu.h"

namespace photond {

/// The cells of a grid about `points` points or so (any number works) within `bounds`, made for searches of radius
/// `cell_m` > 0; where its parts begin in shared arrays, and its room, are the caller's to say.
gpu::HashGridConstants lay_out_grid(const Bounds3& bounds, float cell_m, uint64_t points);
/// Most words of the table that lay_out_grid() asks for: slots and one more.
uint64_t grid_starts_for(uint64_t points);

/// Of keys that are below `values`.
uint32_t key_bits_of(uint32_t values);

/// Photons in the order of their grids, of one grid or more; hash_grid.glsl searches them.
struct GridPhotons {
    /// `more`: room behind the powers for so many records of 16 bytes that are the caller's.
    GridPhotons(gpu::Device& device, uint64_t starts, uint64_t capacity, uint64_t more = 0);
    static uint64_t bytes_for(uint64_t starts, uint64_t capacity, uint64_t more = 0);

    gpu::Buffer starts, places, powers;
};

class HashGridGpu {
public:
    explicit HashGridGpu(gpu::Device& device);

    /// Sorts what the tracer has stored, of a pass of so many paths, by cell; within one by path, then by scattering:
    /// the same order every time.
    void record(gpu::CommandList& commands, const gpu::HashGridConstants& grid, gpu::Buffer& tracer_state,
                uint32_t paths, UnsortedPhotons& photons, GridPhotons& to);
    /// The same of photons that their paths have put in `photons.order` already.
    void record_ordered(gpu::CommandList& commands, const gpu::HashGridConstants& grid, gpu::Buffer& tracer_state,
                        UnsortedPhotons& photons, GridPhotons& to);

    /// Points of any kind, as many as the first word of `count` says: `order` names them, in an order that those of one
    /// cell keep. It is sorted by cell; `keys` are those of its points then, and `starts` say where each slot's begin.
    struct Points {
        gpu::Buffer& count;
        gpu::Buffer& places;  // a position, and a word of the point's own
        gpu::Buffer& keys;
        gpu::Buffer& order;
        gpu::RadixSort& sort;
    };
    void record_cells(gpu::CommandList& commands, const gpu::HashGridConstants& grid, const Points& points,
                      gpu::Buffer& starts);
    /// Where the points of each slot begin, of keys in their order.
    void record_starts(gpu::CommandList& commands, const gpu::HashGridConstants& grid, gpu::Buffer& count,
                       gpu::Buffer& keys, gpu::Buffer& starts);

private:
    gpu::ComputePipeline keys_, starts_, order_;
};

}  // namespace photond
