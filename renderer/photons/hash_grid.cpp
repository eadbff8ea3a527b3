#include "renderer/photons/hash_grid.h"

#include <algorithm>
#include <array>
#include <bit>

#include "renderer/core/parallel.h"
#include "renderer/core/rng.h"
#include "renderer/photons/lane_blocks.h"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace photond {

namespace {

// Rows of cells twice as high and deep as the radius, cells as long as it. Of (2, 1), (2, 1/2), (2, 2), (1, 1/2), (1,
// 1) and (1/2, 1/2) radii this was the fastest with 50 photons found: a search reads four runs, and their points'
// distances cost less than more and shorter runs would. A little more than that, so that rounding does not make them
// five.
constexpr float kRowsPerRadius = 0.99999f / 2;
constexpr float kCellsPerRadiusAlongX = 0.99999f;
// Rows along one axis that a search touches, at most: two, and another where a million cells leave the rounding its
// say.
constexpr size_t kMostRows = 3;
// More cells along an axis would be finer than the coordinates.
constexpr float kMostCells = 0x1p20f;

constexpr size_t kBlock = 1 << 15;       // points that are counted and moved at a time
constexpr uint32_t kMostBuckets = 1024;  // of the first, coarse distribution
constexpr uint32_t kPadding = 16;        // floats that may be read beyond the end

uint64_t table_size(uint64_t points) { return std::bit_ceil(std::max<uint64_t>(points, 64)); }

size_t blocks(size_t points) { return (points + kBlock - 1) / kBlock; }

/// Found points on their way to the caller: stored whole vectors at a time, which a std::vector does not allow.
class FoundBuffer {
public:
    static constexpr uint32_t kRoom = 512;

    explicit FoundBuffer(std::vector<Neighbours::Found>& out) : out_(out) {}

    /// Room for `count` <= kRoom more.
    void make_room(uint32_t count) {
        if (size_ + count > kRoom) flush();
    }
    void flush() {
        out_.insert(out_.end(), found_.begin(), found_.begin() + size_);
        size_ = 0;
    }
    Neighbours::Found* end() { return found_.data() + size_; }
    void grow(uint32_t count) { size_ += count; }

private:
    std::vector<Neighbours::Found>& out_;
    uint32_t size_ = 0;
    std::array<Neighbours::Found, kRoom> found_;
};

#if defined(__AVX2__) && !defined(__AVX512F__)
/// For each mask of four 64-bit lanes the 32-bit lanes that bring those set to the front.
constexpr auto kCompress = [] {
    std::array<std::array<int32_t, 8>, 16> table{};
    for (uint32_t mask = 0; mask < 16; ++mask) {
        size_t to = 0;
        for (int32_t lane = 0; lane < 4; ++lane) {
            if (!(mask >> lane & 1)) continue;
            table[mask][to++] = 2 * lane;
            table[mask][to++] = 2 * lane + 1;
        }
    }
    return table;
}();
#endif

/// Appends the points of a run that are nearer than the radius.
void scan(const float* x, const float* y, const float* z, const vec3& p, float radius_sq, uint32_t begin, uint32_t end,
          FoundBuffer& out) {
    static_assert(sizeof(Neighbours::Found) == 8 && offsetof(Neighbours::Found, index) == 4);
    uint32_t i = begin;
#if defined(__AVX512F__) && defined(__AVX512VL__)
    const __m256 px = _mm256_set1_ps(p.x), py = _mm256_set1_ps(p.y), pz = _mm256_set1_ps(p.z);
    const __m256 limit = _mm256_set1_ps(radius_sq);
    // Forms with a mask, all set, where GCC 12 takes its own undefined operand for ours (GCC bug 105593).
    constexpr __mmask8 kAll = 0xff;
    __m512i index = _mm512_maskz_slli_epi64(
        kAll, _mm512_add_epi64(_mm512_set1_epi64(i), _mm512_setr_epi64(0, 1, 2, 3, 4, 5, 6, 7)), 32);
    for (; i < end; i += 8) {
        const uint32_t left = end - i;
        const __mmask8 valid = static_cast<__mmask8>(left < 8 ? (1u << left) - 1 : 0xffu);
        const __m256 dx = _mm256_sub_ps(_mm256_loadu_ps(x + i), px);
        const __m256 dy = _mm256_sub_ps(_mm256_loadu_ps(y + i), py);
        const __m256 dz = _mm256_sub_ps(_mm256_loadu_ps(z + i), pz);
        const __m256 d_sq = _mm256_fmadd_ps(dz, dz, _mm256_fmadd_ps(dy, dy, _mm256_mul_ps(dx, dx)));
        const __mmask8 near = _mm256_mask_cmp_ps_mask(valid, d_sq, limit, _CMP_LT_OQ);
        const __m512i found = _mm512_or_si512(index, _mm512_maskz_cvtepu32_epi64(kAll, _mm256_castps_si256(d_sq)));
        out.make_room(8);
        _mm512_storeu_si512(out.end(), _mm512_maskz_compress_epi64(near, found));
        out.grow(static_cast<uint32_t>(std::popcount(static_cast<uint32_t>(near))));
        index = _mm512_add_epi64(index, _mm512_set1_epi64(int64_t{8} << 32));
    }
#elif defined(__AVX2__)
    const __m256 px = _mm256_set1_ps(p.x), py = _mm256_set1_ps(p.y), pz = _mm256_set1_ps(p.z);
    const __m256 limit = _mm256_set1_ps(radius_sq);
    const __m256i lanes = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    for (; i < end; i += 8) {
        const uint32_t left = end - i;
        const __m256 dx = _mm256_sub_ps(_mm256_loadu_ps(x + i), px);
        const __m256 dy = _mm256_sub_ps(_mm256_loadu_ps(y + i), py);
        const __m256 dz = _mm256_sub_ps(_mm256_loadu_ps(z + i), pz);
        const __m256 d_sq = _mm256_fmadd_ps(dz, dz, _mm256_fmadd_ps(dy, dy, _mm256_mul_ps(dx, dx)));
        uint32_t near = static_cast<uint32_t>(_mm256_movemask_ps(_mm256_cmp_ps(d_sq, limit, _CMP_LT_OQ)));
        if (left < 8) near &= (1u << left) - 1;
        const __m256i index = _mm256_add_epi32(_mm256_set1_epi32(static_cast<int32_t>(i)), lanes);
        // Unpacking pairs distance and index, of lanes 0, 1, 4, 5 and 2, 3, 6, 7.
        const __m256i halves[2] = {_mm256_unpacklo_epi32(_mm256_castps_si256(d_sq), index),
                                   _mm256_unpackhi_epi32(_mm256_castps_si256(d_sq), index)};
        const uint32_t masks[2] = {(near & 3) | (near >> 2 & 12), (near >> 2 & 3) | (near >> 4 & 12)};
        out.make_room(8);
        for (size_t half = 0; half < 2; ++half) {
            const __m256i to_front =
                _mm256_loadu_si256(reinterpret_cast<const __m256i*>(kCompress[masks[half]].data()));
            _mm256_storeu_si256(reinterpret_cast<__m256i*>(out.end()),
                                _mm256_permutevar8x32_epi32(halves[half], to_front));
            out.grow(static_cast<uint32_t>(std::popcount(masks[half])));
        }
    }
#else
    for (; i < end; ++i) {
        const float d_sq = HashGrid::distance_sq_m2(p, vec3(x[i], y[i], z[i]));
        out.make_room(1);
        *out.end() = {d_sq, i};
        out.grow(d_sq < radius_sq ? 1 : 0);
    }
#endif
}

}  // namespace

HashGrid::HashGrid(std::span<const vec3> points, float radius_m, std::span<uint32_t> order)
    : size_(static_cast<uint32_t>(points.size())), radius_m_(radius_m) {
    assert(radius_m > 0 && "a grid needs a radius");
    assert(order.size() == points.size() && points.size() <= size_t{1} << 31);
    if (points.empty()) return;
    lay_out(points);
    sort(points, order);
}

void HashGrid::lay_out(std::span<const vec3> points) {
    std::vector<Bounds3> block_bounds(blocks(points.size()));
    parallel_for(block_bounds.size(), 1, [&](size_t block) {
        for (const vec3& p : points.subspan(block * kBlock, std::min(kBlock, points.size() - block * kBlock)))
            block_bounds[block].extend(p);
    });
    Bounds3 bounds;
    for (const Bounds3& b : block_bounds) bounds.extend(b);
    origin_ = bounds.min;
    uint64_t cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const float extent = bounds.max[axis] - bounds.min[axis];
        const float finest = kMostCells / extent;  // infinite for a flat box
        const float wanted = (axis == 0 ? kCellsPerRadiusAlongX : kRowsPerRadius) / radius_m_;
        cells_per_m_[axis] = std::min({wanted, finest, std::numeric_limits<float>::max()});
        const float cells_along = extent * cells_per_m_[axis];
        cells_[axis] = (cells_along > 0 ? static_cast<int32_t>(std::min(cells_along, kMostCells)) : 0) + 1;
        cells *= static_cast<uint64_t>(cells_[axis]);
    }
    const uint64_t table = table_size(points.size());
    hashed_ = cells > table;
    slots_ = static_cast<uint32_t>(hashed_ ? table : cells);
}

HashGrid::Cells HashGrid::cell_of(const vec3& p) const {
    Cells cell;
    for (int axis = 0; axis < 3; ++axis) {
        const float t = (p[axis] - origin_[axis]) * cells_per_m_[axis];
        // Written so that NaN, of an infinite extent, is cell 0.
        cell[axis] = t > 0 ? static_cast<int32_t>(std::min(t, static_cast<float>(cells_[axis] - 1))) : 0;
    }
    return cell;
}

inline uint32_t HashGrid::row(int32_t y, int32_t z) const {
    if (hashed_) return hash32(static_cast<uint32_t>(y) ^ hash32(static_cast<uint32_t>(z)));
    return static_cast<uint32_t>(z * cells_.y + y) * static_cast<uint32_t>(cells_.x);
}

inline uint32_t HashGrid::slot_of(const vec3& p) const {
    const Cells cell = cell_of(p);
    const uint32_t slot = row(cell.y, cell.z) + static_cast<uint32_t>(cell.x);
    return hashed_ ? slot & (slots_ - 1) : slot;
}

void HashGrid::sort(std::span<const vec3> points, std::span<uint32_t> order) {
    // First into buckets of neighbouring slots, then each bucket, which fits a cache, by slot. Both sorts are stable
    // and know beforehand where everything goes, so the order is that of (slot, index) for any number of threads.
    struct Keyed {
        uint32_t slot, index;
    };
    const uint32_t shift = static_cast<uint32_t>(
        std::max(0, static_cast<int>(std::bit_width(slots_ - 1)) - std::countr_zero(kMostBuckets)));
    const size_t buckets = ((slots_ - 1) >> shift) + 1;
    std::vector<uint32_t> first(blocks(points.size()) * buckets);  // [block][bucket]
    parallel_for(blocks(points.size()), 1, [&](size_t block) {
        uint32_t* counts = &first[block * buckets];
        for (const vec3& p : points.subspan(block * kBlock, std::min(kBlock, points.size() - block * kBlock)))
            ++counts[slot_of(p) >> shift];
    });
    std::vector<uint32_t> bucket_start(buckets + 1);
    uint32_t sum = 0;
    for (size_t bucket = 0; bucket < buckets; ++bucket) {
        bucket_start[bucket] = sum;
        for (size_t block = 0; block < blocks(points.size()); ++block) {
            const uint32_t count = first[block * buckets + bucket];
            first[block * buckets + bucket] = sum;
            sum += count;
        }
    }
    bucket_start[buckets] = sum;

    std::vector<Keyed> keyed(points.size());
    parallel_for(blocks(points.size()), 1, [&](size_t block) {
        uint32_t* next = &first[block * buckets];
        for (size_t i = block * kBlock; i < std::min(points.size(), (block + 1) * kBlock); ++i) {
            const uint32_t slot = slot_of(points[i]);
            keyed[next[slot >> shift]++] = {slot, static_cast<uint32_t>(i)};
        }
    });

    start_.resize(size_t{slots_} + 1);
    for (std::vector<float>* coordinates : {&x_, &y_, &z_}) coordinates->resize(points.size() + kPadding);
    parallel_for(buckets, 1, [&](size_t bucket) {
        // Entry s + 1 counts slot s, then says where the slot's next point goes, and at last where they end.
        const std::span<const Keyed> members(&keyed[bucket_start[bucket]],
                                             bucket_start[bucket + 1] - bucket_start[bucket]);
        for (const Keyed& k : members) ++start_[k.slot + 1];
        uint32_t next = bucket_start[bucket];
        for (size_t slot = bucket << shift; slot < std::min<size_t>(slots_, (bucket + 1) << shift); ++slot) {
            const uint32_t count = start_[slot + 1];
            start_[slot + 1] = next;
            next += count;
        }
        for (const Keyed& k : members) {
            const uint32_t to = start_[k.slot + 1]++;
            order[to] = k.index;
            x_[to] = points[k.index].x, y_[to] = points[k.index].y, z_[to] = points[k.index].z;
        }
    });
}

/// Calls add(first slot, slots) for the parts of the table that hold the points of those cells.
template <class Add>
inline void HashGrid::visit_runs(const Cells& low, const Cells& high, const Add& add) const {
    const auto columns = static_cast<uint32_t>(high.x - low.x + 1);
    for (int32_t z = low.z; z <= high.z; ++z) {
        for (int32_t y = low.y; y <= high.y; ++y) {
            uint32_t slot = row(y, z) + static_cast<uint32_t>(low.x);
            if (!hashed_) {
                add(slot, columns);
                continue;
            }
            slot &= slots_ - 1;
            const uint32_t before_end = std::min(columns, slots_ - slot);
            add(slot, before_end);
            if (before_end < columns) add(0, columns - before_end);
        }
    }
}

/// Of rows that meet in a hashed table no point is left twice. Sorts the runs; some may end up empty.
inline void HashGrid::take_doubles_out(std::span<Run> runs) {
    std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) { return a.begin < b.begin; });
    uint32_t done = 0;
    for (Run& run : runs) {
        run = {std::max(run.begin, done), std::max(run.end, done)};
        done = run.end;
    }
}

void HashGrid::find_within(const vec3& p, float radius_m, Neighbours& out) const {
    assert(radius_m <= radius_m_ && "the cells are made for a smaller radius");
    out.found.clear();
    out.radius_m = radius_m;
    if (size_ == 0) return;

    // All roundings on the way to a cell are monotonic: a radius that is more than the distance's own rounding too
    // large misses no cell.
    const vec3 reach(radius_m * 1.000001f);
    const Cells low = cell_of(p - reach), high = cell_of(p + reach);
    assert(high.y - low.y < static_cast<int32_t>(kMostRows) && high.z - low.z < static_cast<int32_t>(kMostRows));
    std::array<Run, 2 * kMostRows * kMostRows> runs;
    size_t count = 0;
    visit_runs(low, high, [&](uint32_t first_slot, uint32_t slots) {
        runs[count] = {start_[first_slot], start_[first_slot + slots]};
        count += runs[count].begin != runs[count].end;  // without a branch: most rows are empty, and which is chance
    });
    if (hashed_) take_doubles_out(std::span(runs).first(count));
    for (const Run& run : std::span(runs).first(count)) {
        for (const float* coordinates : {x_.data(), y_.data(), z_.data()}) {
            __builtin_prefetch(coordinates + run.begin);
            __builtin_prefetch(coordinates + run.begin + 16);
        }
    }
    FoundBuffer buffer(out.found);
    for (size_t i = 0; i < count; ++i)
        scan(x_.data(), y_.data(), z_.data(), p, radius_m * radius_m, runs[i].begin, runs[i].end, buffer);
    buffer.flush();
}

void HashGrid::find_near_box(const Bounds3& box, float radius_m, std::vector<uint32_t>& out) const {
    assert(radius_m <= radius_m_ && "the cells are made for a smaller radius");
    if (size_ == 0) return;
    const vec3 reach(radius_m * 1.000001f);
    const Cells low = cell_of(box.min - reach), high = cell_of(box.max + reach);
    std::vector<Run> runs;
    visit_runs(low, high, [&](uint32_t first_slot, uint32_t slots) {
        const Run run{start_[first_slot], start_[first_slot + slots]};
        if (run.begin != run.end) runs.push_back(run);
    });
    if (hashed_) take_doubles_out(runs);
    const float limit_sq = sqr(radius_m) * 1.00001f;
    for (const Run& run : runs) {
        size_t count = out.size();
        out.resize(count + (run.end - run.begin) + kPadding);
        for (uint32_t first = run.begin; first < run.end; first += kPadding) {
            alignas(64) std::array<float, kPadding> distances_sq{};
            std::array<uint32_t, kPadding> indices;
            const auto add_axis = [&](const std::vector<float>& coordinates, float from, float to) {
                for (uint32_t lane = 0; lane < kPadding; ++lane) {
                    const float x = coordinates[first + lane];
                    const float outside = std::max(std::max(from - x, x - to), 0.0f);
                    distances_sq[lane] += outside * outside;
                }
            };
            add_axis(x_, box.min.x, box.max.x);
            add_axis(y_, box.min.y, box.max.y);
            add_axis(z_, box.min.z, box.max.z);
            for (uint32_t lane = 0; lane < kPadding; ++lane) indices[lane] = first + lane;
            for (uint32_t lane = run.end - first; lane < kPadding; ++lane) distances_sq[lane] = kInfinity;
            std::array<float, kPadding> kept;
            count += LaneBlock(distances_sq.data(), indices.data()).store_below(limit_sq, kept.data(), &out[count]);
        }
        out.resize(count);
    }
}

uint64_t HashGrid::bytes() const {
    return start_.capacity() * sizeof(uint32_t) + (x_.capacity() + y_.capacity() + z_.capacity()) * sizeof(float);
}

uint64_t HashGrid::bytes_for(uint64_t points) {
    if (points == 0) return 0;
    return (table_size(points) + 1) * sizeof(uint32_t) + 3 * (points + kPadding) * sizeof(float);
}

uint64_t HashGrid::build_bytes_for(uint64_t points) {
    return points * 2 * sizeof(uint32_t) + (blocks(points) + 1) * kMostBuckets * sizeof(uint32_t);
}

}  // namespace photond
