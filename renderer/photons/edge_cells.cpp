#include "renderer/photons/edge_cells.h"

#include <atomic>
#include <bit>

#include "renderer/core/parallel.h"

namespace photond {

namespace {

constexpr uint64_t kFewestBits = 1 << 12, kMostBits = 1 << 25;  // of a level; 4 MiB: cells beyond share bits

}  // namespace

EdgeCells::EdgeCells(std::span<const SurfaceEdge> edges, float radius_m) : radius_m_(radius_m) {
    for (Level& level : levels_) {
        level = make_level(edges, radius_m);
        radius_m /= kLevelStep;
    }
}

EdgeCells::Level EdgeCells::make_level(std::span<const SurfaceEdge> edges, float radius_m) {
    Level level;
    if (edges.empty()) return level;
    Bounds3 bounds;
    double length_m = 0;
    for (const SurfaceEdge& e : edges) bounds.extend(e.a), bounds.extend(e.b), length_m += glm::length(e.b - e.a);
    level.cells.origin = bounds.min;
    // Cells of twice the radius: an edge reaches into some eight of them. Larger where long edges would take too many,
    // or cells could not be counted in floats.
    const vec3 size = bounds.diagonal();
    const double most_layers = 4 * static_cast<double>(edges.size()) + 65536;
    level.cells.per_m = 1 / std::max({2 * radius_m, static_cast<float>(length_m / most_layers),
                                      std::max({size.x, size.y, size.z}) * 0x1p-20f});

    std::atomic<uint64_t> visits = 0;
    parallel_for(edges.size(), 1024, [&](size_t i) {
        uint64_t own = 0;
        level.cells.for_cells_within(edges[i].a, edges[i].b, radius_m, [&](const vec3&) { ++own; });
        visits.fetch_add(own, std::memory_order_relaxed);
    });
    const uint64_t bits = std::clamp(std::bit_ceil(visits.load()), kFewestBits, kMostBits);
    level.bit_shift = 64 - std::countr_zero(bits);
    level.occupied.assign(bits / 64, 0);
    parallel_for(edges.size(), 1024, [&](size_t i) {
        level.cells.for_cells_within(edges[i].a, edges[i].b, radius_m, [&](const vec3& cell) {
            const uint64_t bit = CubicCells::hash(cell) >> level.bit_shift;
            const std::atomic_ref<uint64_t> word(level.occupied[bit / 64]);
            const uint64_t mask = uint64_t{1} << (bit % 64);
            if ((word.load(std::memory_order_relaxed) & mask) == 0) word.fetch_or(mask, std::memory_order_relaxed);
        });
    });
    return level;
}

bool EdgeCells::may_have_edges(const vec3& p, float radius_m) const {
    size_t index = 0;
    for (float next_m = radius_m_ / kLevelStep; index + 1 < kLevels && radius_m <= next_m; next_m /= kLevelStep)
        ++index;
    const Level& level = levels_[index];
    if (level.occupied.empty()) return false;
    const uint64_t bit = CubicCells::hash(level.cells.cell_of(p)) >> level.bit_shift;
    return level.occupied[bit / 64] >> (bit % 64) & 1;
}

uint64_t EdgeCells::bytes() const {
    uint64_t bytes = 0;
    for (const Level& level : levels_) bytes += level.occupied.size() * sizeof(uint64_t);
    return bytes;
}

uint64_t EdgeCells::estimate_bytes(uint64_t triangles) {
    // Every second edge of a triangle its own, each in some sixteen cells, and up to twice as many bits.
    const uint64_t bits = std::bit_ceil(std::clamp(triangles * 3 / 2 * 16, kFewestBits, kMostBits));
    return kLevels * bits / 8;
}

gpu::DiscCoverageConstants EdgeCells::device_constants(uint32_t first_word) const {
    gpu::DiscCoverageConstants constants{.levels = {}, .radius_m = radius_m_};
    for (size_t i = 0; i < kLevels; ++i) {
        const Level& level = levels_[i];
        constants.levels[i] = {level.cells.origin, level.cells.per_m, first_word,
                               static_cast<uint32_t>(level.bit_shift), level.occupied.empty()};
        first_word += static_cast<uint32_t>(2 * level.occupied.size());
    }
    return constants;
}

std::vector<uint32_t> EdgeCells::device_words() const {
    std::vector<uint32_t> words;
    for (const Level& level : levels_)
        for (const uint64_t word : level.occupied) {
            words.push_back(static_cast<uint32_t>(word));
            words.push_back(static_cast<uint32_t>(word >> 32));
        }
    return words;
}

}  // namespace photond
