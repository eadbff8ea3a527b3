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
    /// For a finished tree. A cell is a brick, but there are at most 2^6 cells along an edge.
    SvoCells(const gpu::SvoConstants& constants, std::span<const gpu::SvoNode> nodes);

    static size_t estimate_bytes(uint32_t resolution);

    size_t plane() const { return size_t{1} << 3 * bits; }  // cells in all
    /// For each cell the side of its free cube, in cells, the cell itself being the first; 0 where it holds set voxels.
    /// Bit i of `octant` is set for rays that go down along axis i.
    const uint8_t* free_cubes(uint32_t octant) const { return free.data() + octant * plane(); }
    size_t bytes() const { return free.size() + starts.size() * sizeof starts[0]; }

    uint32_t bits;                 // log2(cells along an edge)
    uint32_t shift;                // log2(voxels along a cell's edge)
    std::vector<uint32_t> starts;  // x + 2^bits y + 4^bits z: the brick where shift is 2, else the tile; or SVO_NO_DATA
    std::vector<uint8_t> free;     // eight planes of the same order, and 1
};

}  // namespace photond
