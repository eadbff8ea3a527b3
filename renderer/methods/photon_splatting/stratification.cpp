#include "renderer/methods/photon_splatting/stratification.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <limits>
#include <utility>

#include "renderer/core/morton.h"
#include "renderer/core/parallel.h"

namespace photond {

namespace {

// What is sorted: the code of a photon's cell above the photon's index. All keys are different, so that their order is
// the same however they are sorted. Keys of photons without power come after all others.
constexpr uint32_t kIndexBits = 31;
constexpr uint64_t kIndexMask = (uint64_t{1} << kIndexBits) - 1;
constexpr uint64_t kNoPower = ~uint64_t{0};
uint64_t code_of(uint64_t key) { return key >> kIndexBits; }
uint32_t index_of(uint64_t key) { return static_cast<uint32_t>(key & kIndexMask); }

/// The codes of a pass's cells.
class ShiftedGrid {
public:
    explicit ShiftedGrid(const StratificationGrid& grid) : grid_(grid) {}

    /// Levels of blocks above the cells, up to the one that holds all of them.
    uint32_t levels() const { return grid_.levels; }
    /// Greater than all codes of cells.
    uint64_t outside() const {
        assert(grid_.levels <= 11 && "at most 1024 cells along a side");
        // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): it takes bit_width() for anything
        return (uint64_t{1} << 3 * grid_.levels) - 1;
    }

    uint64_t code(const vec3& p) const {
        const vec3 &low = grid_.low, &high = grid_.high;
        // Written so that NaN is outside, as everything is where the bounds are empty.
        const bool inside =
            p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y && p.z >= low.z && p.z <= high.z;
        if (!inside) return outside();
        return morton_code_wide(
            uvec3(glm::ivec3(glm::max(vec3(0), (p - grid_.min) * grid_.cells_per_m + grid_.first))));
    }

private:
    StratificationGrid grid_;
};

/// Sorts in place and in parallel by bits below `high_bit`; all bits above agree. American flag sort: [McIlroy,
/// Bostic, McIlroy 1993] Engineering Radix Sort. Computing Systems 6(1).
void sort_keys(std::span<uint64_t> keys, uint32_t high_bit) {
    constexpr uint32_t kDigitBits = 8, kDigits = 1u << kDigitBits;
    constexpr size_t kWorthTasks = 1 << 15;
    constexpr size_t kFew = 128;  // of 32 to 256, 64 and 128 were the fastest
    if (keys.size() <= kFew || high_bit == 0) {
        std::sort(keys.begin(), keys.end());
        return;
    }
    const uint32_t shift = high_bit > kDigitBits ? high_bit - kDigitBits : 0;
    const auto digit = [shift](uint64_t key) { return key >> shift & (kDigits - 1); };

    std::array<size_t, kDigits> next{}, end;
    bool sorted = true;
    uint64_t last = 0;
    for (const uint64_t key : keys) {
        ++next[digit(key)];
        sorted &= last <= key;
        last = key;
    }
    if (sorted) return;  // all the photons in one cell, for one
    size_t sum = 0;
    for (uint32_t d = 0; d < kDigits; ++d) {
        const size_t count = next[d];
        next[d] = sum;
        end[d] = sum += count;
    }
    for (uint32_t d = 0; d < kDigits; ++d) {
        while (next[d] < end[d]) {
            uint64_t key = keys[next[d]];
            // Each key goes where its digit's keys go, and what lay there is taken along, until one belongs here.
            while (digit(key) != d) std::swap(key, keys[next[digit(key)]++]);
            keys[next[d]++] = key;
        }
    }
    if (shift == 0) return;
    const auto sort_digit = [&](size_t d) {
        const size_t begin = d == 0 ? 0 : end[d - 1];
        sort_keys(keys.subspan(begin, end[d] - begin), shift);
    };
    if (keys.size() < kWorthTasks) {
        for (size_t d = 0; d < kDigits; ++d) sort_digit(d);
    } else {
        parallel_for(kDigits, 1, sort_digit);
    }
}

/// A run of sorted keys: all of a block of that level. Level 0: a cell.
struct Block {
    size_t begin, end;
    uint32_t level;
};

/// Those of a block's eight children that hold photons, in their order.
struct Children {
    std::array<Block, 8> blocks;
    size_t count = 0;
};

Children split(std::span<const uint64_t> keys, const Block& block) {
    Children children;
    const uint32_t shift = kIndexBits + 3 * (block.level - 1);
    for (size_t begin = block.begin; begin != block.end;) {
        const uint64_t last_key = keys[begin] | ((uint64_t{1} << shift) - 1);
        // Doubling steps from the beginning: most children are small.
        size_t step = 1;
        while (begin + step < block.end && keys[begin + step] <= last_key) step *= 2;
        const auto low = keys.begin() + static_cast<ptrdiff_t>(begin + step / 2);
        const auto high = keys.begin() + static_cast<ptrdiff_t>(std::min(begin + step, block.end));
        const auto end = static_cast<size_t>(std::upper_bound(low, high, last_key) - keys.begin());
        children.blocks[children.count++] = {begin, end, block.level - 1};
        begin = end;
    }
    return children;
}

/// Calls visit(cell) for each cell, joined or not, within the block, in Morton order; blocks of `deepest` level are
/// visited where they are not joined.
///
/// Joining level by level from below, as stratify() describes it, means that a photon's cell is the greatest block
/// about it one of whose children holds too few, for a block that holds too few was always joined itself. Found from
/// above, it needs no other memory than the order.
template <class Visit>
void for_each_cell(std::span<const uint64_t> keys, const Block& block, size_t minimum_photons, uint32_t deepest,
                   const Visit& visit) {
    if (block.level == deepest) return visit(block, false);
    const Children children = split(keys, block);
    const auto blocks = std::span(children.blocks).first(children.count);
    if (std::ranges::any_of(blocks, [&](const Block& child) { return child.end - child.begin < minimum_photons; }))
        return visit(block, true);
    for (const Block& child : blocks) for_each_cell(keys, child, minimum_photons, deepest, visit);
}

/// Chooses the splats of cells.
class Chooser {
public:
    Chooser(std::span<const ReflectedPhoton> photons, std::span<const uint64_t> keys,
            const StratificationSettings& settings, uint64_t seed, uint32_t pass)
        : photons_(photons), keys_(keys), settings_(settings), seed_(seed), pass_(pass) {}

    bool takes_one() const {
        return settings_.representative == Representative::ClosestToMean ||
               settings_.representative == Representative::DominantDirection;
    }
    size_t splats(const Block& cell) const {
        return takes_one() ? 1 : std::min<size_t>(settings_.splats_per_cell, cell.end - cell.begin);
    }
    /// Writes the cell's splats.
    void choose(const Block& cell, SplatSource* out) const {
        const size_t count = cell.end - cell.begin;
        fetch(cell.end, std::min(cell.end + std::min<size_t>(count, 32), keys_.size()));
        if (takes_one() && count > 1) {
            *out = representative(cell);
        } else if (count <= settings_.splats_per_cell || takes_one()) {
            for (size_t k = cell.begin; k < cell.end; ++k) *out++ = {index_of(keys_[k]), photon(k).power_w, 1};
        } else {
            sample(cell, out);
        }
    }

private:
    const ReflectedPhoton& photon(size_t k) const { return photons_[index_of(keys_[k])]; }
    /// Photons of neighbouring cells lie anywhere.
    void fetch(size_t begin, size_t end) const {
        for (size_t k = begin; k < end; ++k) __builtin_prefetch(&photon(k));
    }
    static double weight(const Rgb& power_w) { return double{power_w.x} + double{power_w.y} + double{power_w.z}; }
    /// Uniform in [0, 1), 53 bits: a cell may hold so many photons that the chance of each is no multiple of 2^-24.
    double random_offset(const Block& cell) const {
        RandomStream random(seed_, RandomDomain::Stratification, pass_,
                            code_of(keys_[cell.begin]) >> 3 * cell.level << 4 | cell.level);
        const uint64_t high = random.next_bits();
        return static_cast<double>(high << 21 | random.next_bits() >> 11) * 0x1p-53;
    }
    dvec3 sum_w(const Block& cell) const {
        dvec3 sum(0);
        for (size_t k = cell.begin; k < cell.end; ++k) sum += dvec3(photon(k).power_w);
        return sum;
    }

    void sample(const Block& cell, SplatSource* out) const;
    SplatSource representative(const Block& cell) const;
    size_t closest_to_mean(const Block& cell) const;
    size_t dominant_direction(const Block& cell) const;

    const std::span<const ReflectedPhoton> photons_;
    const std::span<const uint64_t> keys_;
    const StratificationSettings& settings_;
    const uint64_t seed_;
    const uint32_t pass_;
};

void Chooser::sample(const Block& cell, SplatSource* out) const {
    const bool by_power = settings_.representative == Representative::ByPower;
    const double count = static_cast<double>(cell.end - cell.begin), splats = settings_.splats_per_cell;
    const auto share = [&](size_t k) { return by_power ? weight(photon(k).power_w) : 1.0; };
    double total = count;
    if (by_power) {
        total = 0;  // in the order of the sum below, so that both end at the same number
        for (size_t k = cell.begin; k < cell.end; ++k) total += share(k);
    }
    const Rgb mean_w = settings_.mean_power ? Rgb(sum_w(cell) / count) : Rgb(0);
    const double offset = random_offset(cell);
    size_t k = cell.begin;
    double reached = share(k);  // cumulative share of the photons up to k
    for (uint32_t i = 0; i < settings_.splats_per_cell; ++i) {
        const double point = (offset + i) * (total / splats);
        while (reached <= point && k + 1 < cell.end) reached += share(++k);
        const dvec3 splat_w = dvec3(photon(k).power_w) * (total / (splats * share(k)));
        *out++ = {index_of(keys_[k]), settings_.mean_power ? mean_w : Rgb(splat_w), static_cast<float>(count / splats)};
    }
}

SplatSource Chooser::representative(const Block& cell) const {
    const size_t k =
        settings_.representative == Representative::ClosestToMean ? closest_to_mean(cell) : dominant_direction(cell);
    const double count = static_cast<double>(cell.end - cell.begin);
    return {index_of(keys_[k]), Rgb(sum_w(cell) / (settings_.mean_power ? count : 1.0)), static_cast<float>(count)};
}

size_t Chooser::closest_to_mean(const Block& cell) const {
    dvec3 sum(0);
    for (size_t k = cell.begin; k < cell.end; ++k) sum += dvec3(photon(k).position);
    const dvec3 mean = sum / static_cast<double>(cell.end - cell.begin);
    size_t best = cell.begin;
    double least_m2 = std::numeric_limits<double>::infinity();
    for (size_t k = cell.begin; k < cell.end; ++k) {
        const dvec3 d = dvec3(photon(k).position) - mean;
        if (const double distance_m2 = glm::dot(d, d); distance_m2 < least_m2) best = k, least_m2 = distance_m2;
    }
    return best;
}

size_t Chooser::dominant_direction(const Block& cell) const {
    dvec3 sum(0);
    for (size_t k = cell.begin; k < cell.end; ++k) sum += weight(photon(k).power_w) * dvec3(photon(k).direction);
    size_t best = cell.begin;
    double greatest = -std::numeric_limits<double>::infinity();
    for (size_t k = cell.begin; k < cell.end; ++k) {
        const double along = glm::dot(dvec3(photon(k).direction), sum);
        if (along > greatest) best = k, greatest = along;
    }
    return best;
}

/// Keys of all photons, sorted; those without power behind `usable`.
struct SortedKeys {
    std::vector<uint64_t> keys;
    size_t inside = 0;  // the grid
    size_t usable = 0;
};

bool has_power(const ReflectedPhoton& photon) {
    assert(is_finite(photon.power_w) && "no photon's power is infinite");
    assert(std::min({photon.power_w.x, photon.power_w.y, photon.power_w.z}) >= 0 && "no photon takes light away");
    return !is_black(photon.power_w);
}

SortedKeys sort_photons(std::span<const ReflectedPhoton> photons, const ShiftedGrid& grid) {
    SortedKeys sorted{std::vector<uint64_t>(photons.size())};
    constexpr size_t kChunk = 4096;
    parallel_for((photons.size() + kChunk - 1) / kChunk, 1, [&, grid](size_t chunk) {
        uint64_t* keys = sorted.keys.data();
        for (size_t i = chunk * kChunk; i < std::min(photons.size(), (chunk + 1) * kChunk); ++i)
            keys[i] = has_power(photons[i]) ? grid.code(photons[i].position) << kIndexBits | i : kNoPower;
    });
    const auto powerless =
        std::partition(sorted.keys.begin(), sorted.keys.end(), [](uint64_t key) { return key != kNoPower; });
    sorted.usable = static_cast<size_t>(powerless - sorted.keys.begin());
    sort_keys(std::span(sorted.keys).first(sorted.usable), 3 * grid.levels() + kIndexBits);
    sorted.inside = static_cast<size_t>(std::lower_bound(sorted.keys.begin(), powerless, grid.outside() << kIndexBits) -
                                        sorted.keys.begin());
    return sorted;
}

/// Part of the grid that one thread goes through: a block of kTaskLevels below the top, or a cell joined above it.
struct Task {
    Block block;
    bool joined;
    size_t splats;  // of the tasks before it, once known
};
constexpr uint32_t kTaskLevels = 4;

}  // namespace

StratificationGrid::StratificationGrid(const StratificationSettings& settings, uint64_t seed, uint32_t pass)
    : min(settings.bounds.min) {
    constexpr float kMargin = 0.5f;                  // cells
    constexpr uint64_t kShiftStream = ~uint64_t{0};  // unlike any cell's
    const vec3 extent = settings.bounds.empty() ? vec3(0) : settings.bounds.diagonal();
    const float cell_m = max_component(extent) / static_cast<float>(settings.cells);
    // A grid about a single point has one cell.
    cells_per_m = cell_m > 0 && std::isfinite(1 / cell_m) ? 1 / cell_m : 0;
    low = settings.bounds.min - kMargin * cell_m;
    high = settings.bounds.max + kMargin * cell_m;
    RandomStream random(seed, RandomDomain::Stratification, pass, kShiftStream);
    for (int axis = 0; axis < 3; ++axis) first[axis] = kMargin + random.next();
    // The bounds, a margin at either end and the shift come to cells + 2; one more for rounding, one for outside().
    levels = static_cast<uint32_t>(std::bit_width(settings.cells + 3));
}

std::vector<SplatSource> stratify(std::span<const ReflectedPhoton> photons, const StratificationSettings& settings,
                                  uint64_t seed, uint32_t pass, uint64_t& peak_bytes) {
    assert(settings.cells >= 1 && settings.cells <= 1024 && settings.splats_per_cell >= 1);
    assert(photons.size() < kIndexMask && "indices have 31 bits");
    const ShiftedGrid grid(StratificationGrid(settings, seed, pass));
    const SortedKeys sorted = sort_photons(photons, grid);
    const auto keys = std::span(sorted.keys).first(sorted.usable);
    const Chooser chooser(photons, keys, settings, seed, pass);

    std::vector<Task> tasks;
    const uint32_t task_level = grid.levels() > kTaskLevels ? grid.levels() - kTaskLevels : 0;
    if (sorted.inside > 0) {
        for_each_cell(keys, {0, sorted.inside, grid.levels()}, settings.minimum_photons, task_level,
                      [&](const Block& block, bool joined) {
                          tasks.push_back({block, joined, 0});
                      });
    }
    // Twice through the cells, so that what is returned is no larger than it must be.
    const auto for_each_cell_of = [&](const Task& task, const auto& visit) {
        if (task.joined) return visit(task.block);
        for_each_cell(keys, task.block, settings.minimum_photons, 0, [&](const Block& cell, bool) { visit(cell); });
    };
    parallel_for(tasks.size(), 1, [&](size_t t) {
        for_each_cell_of(tasks[t], [&](const Block& cell) { tasks[t].splats += chooser.splats(cell); });
    });
    size_t inside_splats = 0;
    for (Task& task : tasks) inside_splats += std::exchange(task.splats, inside_splats);

    std::vector<SplatSource> splats(inside_splats + keys.size() - sorted.inside);
    parallel_for(tasks.size(), 1, [&](size_t t) {
        SplatSource* out = &splats[tasks[t].splats];
        for_each_cell_of(tasks[t], [&](const Block& cell) {
            chooser.choose(cell, out);
            out += chooser.splats(cell);
        });
    });
    for (size_t k = sorted.inside; k < keys.size(); ++k) chooser.choose({k, k + 1, 0}, &splats[inside_splats++]);
    peak_bytes = sorted.keys.capacity() * sizeof(uint64_t) + tasks.capacity() * sizeof(Task);
    return splats;
}

uint64_t stratification_bytes(uint64_t photons) {
    // No photon makes more than one splat of its own, and no task is without a photon; vectors grow by doubling.
    constexpr uint64_t kMostTasks = uint64_t{1} << 3 * kTaskLevels;
    return photons * (sizeof(uint64_t) + sizeof(SplatSource)) + 2 * std::min(photons, kMostTasks) * sizeof(Task);
}

}  // namespace photond
