#pragma once
// What lies ahead of a ray in a voxel octree, by cells of a coarse grid: how far it may go at once. For the CPU alone;
// it changes no answer.
//
// An octree's empty boxes are small wherever something is near, behind a ray as well as before it. A cell's free cube
// is the largest in one of the eight octants of directions that begins with the cell and holds no set voxel.
//
// [Sramek and Kaufman 2000] Fast Ray-Tracing of Rectilinear Volume Data Using Distance Transforms. IEEE TVCG 6(3).
// Departure: one distance an octant.

#include <span>
#include <vector>

#include "renderer/voxels/svo_shared.h"

namespace photond {

struct SvoCells {
    /// Of a finished tree: a cell a brick, of more than 2^6 bricks along an edge 2^6 cells.
    SvoCells(const gpu::SvoConstants& constants, std::span<const gpu::SvoNode> nodes);

    static size_t estimate_bytes(uint32_t resolution);

    size_t plane() const { return size_t{1} << 3 * bits; }  // cells in all
    /// Of octant s: bit i is set where rays go down along axis i. In cells, itself the first; 0: it holds set voxels.
    const uint8_t* free_cubes(uint32_t octant) const { return free.data() + octant * plane(); }
    size_t bytes() const { return free.size() + starts.size() * sizeof starts[0]; }

    uint32_t bits;                 // log2(cells along an edge)
    uint32_t shift;                // log2(voxels along a cell's edge)
    std::vector<uint32_t> starts;  // x + 2^bits y + 4^bits z: the brick where shift is 2, else the tile; or SVO_NO_DATA
    std::vector<uint8_t> free;     // eight planes of the same order, and 1
};

}  // namespace photond
