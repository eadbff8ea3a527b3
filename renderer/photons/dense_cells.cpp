#include "renderer/photons/dense_cells.h"

#include <atomic>
#include <bit>

#include "renderer/photons/world_triangles.h"

namespace photond {

namespace {

void sort_unique(std::vector<uint64_t>& keys) {
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

std::vector<uint64_t> with_neighbours(const std::vector<uint64_t>& keys) {
    std::vector<uint64_t> near;
    near.reserve(27 * keys.size());
    for (const uint64_t key : keys) {
        const vec3 cell = CellSet::cell_of_key(key);
        for (int i = 0; i < 27; ++i) {
            const vec3 other = cell + vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
            if (CellSet::within_range(other)) near.push_back(CubicCells::key(other));
        }
    }
    sort_unique(near);
    return near;
}

/// The cells, from `low` to `high`, until visit(cell) is true of one.
template <class Visit>
bool any_cell(const vec3& low, const vec3& high, const Visit& visit) {
    vec3 cell;
    for (cell.x = low.x; cell.x <= high.x; ++cell.x)
        for (cell.y = low.y; cell.y <= high.y; ++cell.y)
            for (cell.z = low.z; cell.z <= high.z; ++cell.z)
                if (visit(cell)) return true;
    return false;
}

bool overlap(const vec3& cell, const vec3& low, const vec3& high) {
    return glm::all(glm::lessThanEqual(low, cell)) && glm::all(glm::lessThanEqual(cell, high));
}

}  // namespace

CellSet::CellSet(std::vector<uint64_t> keys) : keys_(std::move(keys)) {
    if (keys_.empty()) return;
    table_.assign(std::bit_ceil(2 * keys_.size()), kNone);
    for (const uint64_t key : keys_) {
        uint64_t slot = hash64(key) & (table_.size() - 1);
        while (table_[slot] != kNone) slot = (slot + 1) & (table_.size() - 1);
        table_[slot] = key;
    }
}

vec3 CellSet::cell_of_key(uint64_t key) {
    const auto number = [&](int shift) {  // 21 bits with a sign
        return static_cast<float>(static_cast<int32_t>(static_cast<uint32_t>(key >> shift) << 11) >> 11);
    };
    return {number(0), number(21), number(42)};
}

CubicCells DenseCells::cells_of(int level) const { return {origin_, std::ldexp(0.5f / radius_m_, level)}; }

DenseCells::DenseCells(std::span<const BoundaryEdge> edges, float radius_m, size_t most_edges) : radius_m_(radius_m) {
    if (edges.size() <= most_edges) return;
    Bounds3 bounds;
    double length_m = 0;
    std::vector<Line> lines;
    lines.reserve(edges.size());
    for (const BoundaryEdge& e : edges) {
        bounds.extend(e.a), bounds.extend(e.b), length_m += glm::length(e.b - e.a);
        lines.push_back({e.a, e.b});
    }
    origin_ = bounds.min;
    const vec3 size = bounds.diagonal();
    const float longest = std::max({size.x, size.y, size.z});
    // Begins with cells so large that edges reach into few of them, and that floats can count them.
    const double most_layers = 4 * static_cast<double>(edges.size()) + 65536;
    const float least_cell_m = std::max(static_cast<float>(length_m / most_layers), longest * 0x1p-18f);
    int level = 0;
    while (std::ldexp(2 * radius_m, -level) < least_cell_m) --level;
    for (; level < static_cast<int>(kMostLevels); ++level) {
        const CubicCells cells = cells_of(level);
        if (longest * cells.per_m > 0x1p18f) break;
        std::vector<uint64_t> dense = find_dense(lines, cells, most_edges);
        if (dense.empty()) break;
        CellSet near(with_neighbours(dense));
        levels_.push_back({cells, CellSet(std::move(dense)), std::move(near)});
        if (levels_.size() == 1) add_parents();
        if (level <= 0) first_ = levels_.size() - 1;
    }
    if (level <= 0) levels_.clear(), first_ = 0;  // nothing dense at the first level, or no cells so small
}

/// Calls visit(cell) for cells among which are all those within half a cell of the line, some more than once; where a
/// coarser level is known only in its dense cells. Long lines are cut, and what is far from dense cells is left out.
template <class Visit>
void DenseCells::visit_cells(const Line& line, const CubicCells& cells, const Visit& visit) const {
    constexpr float kLong = 8;  // cells
    const float reach_m = 0.5f / cells.per_m;
    const auto [a, b] = line;
    if (levels_.empty()) return cells.for_cells_within(a, b, reach_m, visit);
    const Level& above = levels_.back();
    if (sqr(cells.per_m) * glm::dot(b - a, b - a) < sqr(kLong)) {
        vec3 last(kInfinity);
        bool in_dense = false;
        return cells.for_cells_within(a, b, reach_m, [&](const vec3& cell) {
            const vec3 parent = glm::floor(0.5f * cell);
            if (parent != last) last = parent, in_dense = above.dense.contains(parent);
            if (in_dense) visit(cell);
        });
    }
    const vec3 middle = 0.5f * (a + b);
    for (const vec3& end : {a, b}) {
        Bounds3 box;
        box.extend(middle), box.extend(end);
        box.min -= 1.01f * reach_m, box.max += 1.01f * reach_m;
        if (touches(levels_.size() - 1, box)) visit_cells({end, middle}, cells, visit);
    }
}

/// The cells that more than `most_edges` lines lie near, sorted. Leaves only such lines in `lines`.
std::vector<uint64_t> DenseCells::find_dense(std::vector<Line>& lines, const CubicCells& cells,
                                             size_t most_edges) const {
    // Cells that share a counter are at worst dense without need.
    const uint64_t counters = std::clamp<uint64_t>(std::bit_ceil(4 * lines.size()), 1 << 12, 1 << 22);
    const int shift = 64 - std::countr_zero(counters);
    std::vector<std::atomic<uint32_t>> lines_near(counters);
    parallel_for(lines.size(), 1024, [&](size_t i) {
        visit_cells(lines[i], cells, [&](const vec3& cell) {
            lines_near[CubicCells::hash(cell) >> shift].fetch_add(1, std::memory_order_relaxed);
        });
    });
    if (std::none_of(lines_near.begin(), lines_near.end(), [&](const auto& count) { return count > most_edges; }))
        return {};

    constexpr uint64_t kNone = UINT64_MAX;
    std::vector<std::atomic<uint64_t>> noted(counters);  // one of the cells of each counter
    parallel_for(counters, 65536, [&](size_t i) { noted[i].store(kNone, std::memory_order_relaxed); });
    std::vector<uint8_t> stays(lines.size());
    std::vector<uint64_t> dense =
        gather_blocks<uint64_t>(lines.size(), [&](size_t begin, size_t end, std::vector<uint64_t>& out) {
            for (size_t i = begin; i < end; ++i) {
                visit_cells(lines[i], cells, [&](const vec3& cell) {
                    const uint64_t slot = CubicCells::hash(cell) >> shift;
                    if (lines_near[slot].load(std::memory_order_relaxed) <= most_edges) return;
                    if (!CellSet::within_range(cell)) return;
                    stays[i] = 1;
                    uint64_t now = noted[slot].load(std::memory_order_relaxed);
                    const uint64_t key = CubicCells::key(cell);
                    if (now == key) return;
                    if (now == kNone && !noted[slot].compare_exchange_strong(now, key, std::memory_order_relaxed) &&
                        now == key)
                        return;
                    out.push_back(key);
                });
            }
        });
    sort_unique(dense);
    size_t left = 0;
    for (size_t i = 0; i < lines.size(); ++i)
        if (stays[i]) lines[left++] = lines[i];
    lines.resize(left);
    return dense;
}

/// The cells that hold those of the one level there is, and so on up to where there are few.
void DenseCells::add_parents() {
    constexpr size_t kFew = 8;
    while (levels_.front().near.keys().size() > kFew) {
        const Level& child = levels_.front();
        std::vector<uint64_t> parents;
        parents.reserve(child.near.keys().size());
        for (const uint64_t key : child.near.keys())
            parents.push_back(CubicCells::key(glm::floor(0.5f * CellSet::cell_of_key(key))));
        sort_unique(parents);
        levels_.insert(levels_.begin(), {{origin_, 0.5f * child.cells.per_m}, {}, CellSet(std::move(parents))});
    }
}

/// Whether the box touches a near cell of levels_[index]. From the level on whose cells are as large as the box.
bool DenseCells::touches(size_t index, const Bounds3& box) const {
    const vec3 size = box.diagonal();
    const float longest = std::max({size.x, size.y, size.z});
    size_t at = index;
    while (at > 0 && longest * levels_[at].cells.per_m > 1) --at;
    const Level& level = levels_[at];
    const vec3 low = level.cells.cell_of(box.min), high = level.cells.cell_of(box.max);
    if (longest * level.cells.per_m > 1) {  // larger than the largest
        return std::any_of(level.near.keys().begin(), level.near.keys().end(), [&](uint64_t key) {
            const vec3 cell = CellSet::cell_of_key(key);
            return overlap(cell, low, high) && touches_below(at, cell, index, box);
        });
    }
    return any_cell(low, high,
                    [&](const vec3& cell) { return level.near.contains(cell) && touches_below(at, cell, index, box); });
}

bool DenseCells::in_near_cell(size_t level, const Bounds3& box) const {
    const Level& l = levels_[first_ + level];
    const vec3 cell = l.cells.cell_of(box.min);
    return cell == l.cells.cell_of(box.max) && l.near.contains(cell);
}

bool DenseCells::touches_below(size_t at, const vec3& cell, size_t index, const Bounds3& box) const {
    if (at == index) return true;
    const Level& next = levels_[at + 1];
    const vec3 low = glm::max(next.cells.cell_of(box.min), 2.0f * cell),
               high = glm::min(next.cells.cell_of(box.max), 2.0f * cell + 1.0f);
    return any_cell(low, high, [&](const vec3& child) {
        return next.near.contains(child) && touches_below(at + 1, child, index, box);
    });
}

uint64_t DenseCells::bytes() const {
    uint64_t bytes = levels_.capacity() * sizeof(Level);
    for (const Level& level : levels_) bytes += level.dense.bytes() + level.near.bytes();
    return bytes;
}

}  // namespace photond
