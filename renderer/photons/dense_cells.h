#pragma once
// Where boundary edges lie so close together that a disc of density estimation may meet very many of them.
//
// Levels of cubic cells, each with discs of half the radius of the one before; cells are as long as two radii of their
// level. A cell is dense when more than so many edges lie within the radius of it. Eight cells of a level make one of
// the level before, and what is near one of them is near that: so only dense cells are looked at more closely, and the
// levels end where none is dense.

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/photons/boundary_edges.h"
#include "renderer/photons/cubic_cells.h"

namespace photond {

/// A set of cells less than 2^20 from the origin.
class CellSet {
public:
    CellSet() = default;
    /// Keys of CubicCells, sorted, each once.
    explicit CellSet(std::vector<uint64_t> keys);

    bool contains(const vec3& cell) const {
        if (keys_.empty() || !within_range(cell)) return false;
        const uint64_t key = CubicCells::key(cell), mask = table_.size() - 1;
        for (uint64_t slot = hash64(key) & mask; table_[slot] != kNone; slot = (slot + 1) & mask)
            if (table_[slot] == key) return true;
        return false;
    }
    const std::vector<uint64_t>& keys() const { return keys_; }
    uint64_t bytes() const { return (table_.size() + keys_.size()) * sizeof(uint64_t); }

    static bool within_range(const vec3& cell) {
        constexpr float kMost = 0x1p20f - 1;
        return std::fabs(cell.x) < kMost && std::fabs(cell.y) < kMost && std::fabs(cell.z) < kMost;
    }
    static vec3 cell_of_key(uint64_t key);

private:
    static constexpr uint64_t kNone = UINT64_MAX;  // keys have 63 bits
    std::vector<uint64_t> keys_, table_;
};

class DenseCells {
public:
    /// Levels of discs of radius_m, radius_m / 2, ...; dense is what more than `most_edges` edges lie near. The same
    /// for any number of threads.
    DenseCells(std::span<const BoundaryEdge> edges, float radius_m, size_t most_edges);

    /// Those with a dense cell, but at most kMostLevels.
    size_t levels() const { return levels_.size() - first_; }
    float radius_m(size_t level) const { return std::ldexp(radius_m_, -static_cast<int>(level)); }
    /// Whether p lies in a dense cell of that level.
    bool dense(size_t level, const vec3& p) const {
        const Level& l = levels_[first_ + level];
        return l.dense.contains(l.cells.cell_of(p));
    }
    /// Whether the box has a part in a dense cell of that level or in one of the 26 about it: that holds whatever is
    /// within the level's radius of a place in a dense cell.
    bool touches_near(size_t level, const Bounds3& box) const { return touches(first_ + level, box); }
    /// Whether the box lies within one such cell.
    bool in_near_cell(size_t level, const Bounds3& box) const;
    const CubicCells& cells(size_t level) const { return levels_[first_ + level].cells; }

    uint64_t bytes() const;

private:
    static constexpr size_t kMostLevels = 8;  // discs are hardly ever smaller than a 256th of the largest
    struct Level {
        CubicCells cells;
        CellSet dense;  // empty of levels coarser than the first
        CellSet near;   // and their neighbours
    };
    struct Line {
        vec3 a, b;
    };
    CubicCells cells_of(int level) const;
    std::vector<uint64_t> find_dense(std::vector<Line>& lines, const CubicCells& cells, size_t most_edges) const;
    template <class Visit>
    void visit_cells(const Line& line, const CubicCells& cells, const Visit& visit) const;
    void add_parents();
    bool touches(size_t index, const Bounds3& box) const;
    bool touches_below(size_t at, const vec3& cell, size_t index, const Bounds3& box) const;

    float radius_m_;
    vec3 origin_{0};
    std::vector<Level> levels_;  // coarser ones first, for boxes that are larger than the cells
    size_t first_ = 0;           // of levels_
};

}  // namespace photond
