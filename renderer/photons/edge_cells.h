#pragma once
// Where surfaces end, meet or turn sharply: a table of occupied cells that most discs of density estimation leave after
// one look.

#include <array>
#include <span>
#include <vector>

#include "renderer/photons/cubic_cells.h"
#include "renderer/photons/disc_coverage_shared.h"

namespace photond {

/// From corner to corner of a triangle, in world space [m].
struct SurfaceEdge {
    vec3 a, b;
};

class EdgeCells {
public:
    /// For discs of at most `radius_m`. The same for any number of threads.
    EdgeCells(std::span<const SurfaceEdge> edges, float radius_m);

    /// False: no edge within `radius_m` of p, which is at most that of the constructor. True: perhaps one.
    bool may_have_edges(const vec3& p, float radius_m) const;

    /// Tables for discs of the greatest radius, of a quarter of it, and so on: small discs are not asked for edges that
    /// are near large ones only.
    static constexpr size_t kLevels = EDGE_CELL_LEVELS;
    static constexpr float kLevelStep = EDGE_CELL_STEP;

    uint64_t bytes() const;
    /// The most that cells of a scene of so many triangles may take.
    static uint64_t estimate_bytes(uint64_t triangles);

    /// For the twin in disc_coverage.glsl: the tables' words, and where they lie when the first of them has that
    /// number.
    std::vector<uint32_t> device_words() const;
    gpu::DiscCoverageConstants device_constants(uint32_t first_word) const;

private:
    struct Level {
        CubicCells cells;
        int bit_shift = 0;
        std::vector<uint64_t> occupied;  // one bit for the cells of each hash; empty without an edge
    };
    static Level make_level(std::span<const SurfaceEdge> edges, float radius_m);

    float radius_m_;
    std::array<Level, kLevels> levels_;
};

}  // namespace photond
