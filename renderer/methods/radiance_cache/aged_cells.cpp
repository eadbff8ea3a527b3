#include "renderer/methods/radiance_cache/aged_cells.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "protocol/error.h"
#include "renderer/core/copy_elements.h"
#include "renderer/core/rng.h"
#include "renderer/methods/radiance_cache/radiance_cells.h"

namespace photond {

namespace {

constexpr uint32_t kCellsMagic = 0x4c4c4543, kCellsVersion = 1;  // "CELL"
/// More would not be told from as many, and sums are to have room.
constexpr uint32_t kMostAgedSamples = 1u << 20;

struct CellsHead {
    uint32_t magic, version, buckets, cells;
    vec3 origin;
    float coarsest_m;
};

// Cells of the frame before lie before the first round, those that it did not see so far before that they make room at
// once where that is wanted.
uint32_t round_before_frame(uint32_t age) { return RadianceCells::kMostAge + age; }
uint32_t last_round_of(uint32_t frames_unseen, uint32_t age) {
    return frames_unseen == 0 ? round_before_frame(age) : age - frames_unseen;
}
uint32_t frames_unseen_by(uint32_t last_round, uint32_t age) {
    if (last_round > round_before_frame(age)) return 0;
    return last_round == round_before_frame(age) ? 1 : age - last_round + 1;
}

/// Samples that a cell's count as in the next frame, rounded by chance.
uint32_t aged_samples(uint32_t samples, uint32_t age, float u) {
    const double left = static_cast<double>(std::min(samples, kMostAgedSamples)) * (age - 1) / age;
    return static_cast<uint32_t>(left + double{u});
}

}  // namespace

std::string LeftCells::encode() const {
    const CellsHead head{kCellsMagic, kCellsVersion, buckets, static_cast<uint32_t>(cells.size()), origin, coarsest_m};
    std::string text(reinterpret_cast<const char*>(&head), sizeof head);
    return text.append(reinterpret_cast<const char*>(cells.data()), cells.size() * sizeof(LeftCell));
}

LeftCells LeftCells::decode(std::string_view text, uint32_t buckets) {
    CellsHead head{};
    if (text.size() >= sizeof head) std::memcpy(&head, text.data(), sizeof head);
    if (head.magic != kCellsMagic || head.version != kCellsVersion || head.buckets != buckets ||
        text.size() != sizeof head + head.cells * sizeof(LeftCell))
        throw Error(ErrorCode::Conflict, "the frame before left no cells of such a cache");
    LeftCells left{.buckets = buckets, .origin = head.origin, .coarsest_m = head.coarsest_m, .cells = {}};
    left.cells.resize(head.cells);
    copy_elements(text.data() + sizeof head, std::span(left.cells));
    for (size_t i = 0; i < left.cells.size(); ++i) {
        const LeftCell& cell = left.cells[i];
        constexpr uint32_t kSlots = RadianceCells::kSlots;
        if (cell.bucket >= buckets || (i > 0 && cell.bucket < left.cells[i - 1].bucket) ||
            (i >= kSlots && cell.bucket == left.cells[i - kSlots].bucket) || cell.fingerprint == 0)
            throw Error(ErrorCode::Conflict, "the frame before left a table that cannot be");
    }
    return left;
}

uint64_t LeftCells::bytes_for(uint32_t cells) {
    return sizeof(CellsHead) + uint64_t{RadianceCells::buckets_for(cells)} * RadianceCells::kSlots * sizeof(LeftCell);
}

AgedCells::AgedCells(const LeftCells& before, uint32_t age, uint32_t key) : round(round_before_frame(age)) {
    double sum = 0;
    for (const LeftCell& cell : before.cells)
        sum += (double{cell.radiance.x} + double{cell.radiance.y} + double{cell.radiance.z}) / 3;
    if (sum > 0)
        unit = static_cast<float>(sum / static_cast<double>(before.cells.size()) / double{RadianceCells::kUnitsOfMean});
    cells.reserve(before.cells.size());
    uint32_t bucket = 0, place = 0;
    for (const LeftCell& cell : before.cells) {
        const uint32_t samples =
            aged_samples(cell.samples, age, to_unit_float(hash32(cell.fingerprint ^ hash32(cell.bucket ^ key))));
        if (samples == 0 || cell.frames_unseen >= age) continue;
        if (cell.bucket != bucket) bucket = cell.bucket, place = 0;
        AgedCell aged{.slot = bucket * RadianceCells::kSlots + place++,
                      .fingerprint = cell.fingerprint,
                      .units = {0, 0, 0},
                      .samples = samples,
                      .last_round = last_round_of(cell.frames_unseen, age)};
        if (unit > 0)
            for (int c = 0; c < 3; ++c)
                aged.units[c] = static_cast<uint64_t>(std::floor(
                    std::min(double{cell.radiance[c]} / double{unit}, double{RadianceCells::kMostUnits}) * samples +
                    0.5));
        cells.push_back(aged);
    }
}

CellsBetweenFrames::CellsBetweenFrames(const RadianceCacheParams& params)
    : aged_(params.aged), age_(params.cache_age), buckets_(RadianceCells::buckets_for(params.cells)) {
    if (aged_) left_ = LeftCells{.buckets = buckets_, .origin = {}, .coarsest_m = 1, .cells = {}}.encode();
}

uint64_t CellsBetweenFrames::bytes_for(const RadianceCacheParams& params) {
    // The frame before as it was left and aged, and what this one leaves, twice while it is made.
    constexpr uint64_t kTimesLeft = 3;
    const uint64_t slots = uint64_t{RadianceCells::buckets_for(params.cells)} * RadianceCells::kSlots;
    return params.aged ? kTimesLeft * LeftCells::bytes_for(params.cells) + slots * sizeof(AgedCell) : 0;
}

void CellsBetweenFrames::follow(const FrameBefore& before) {
    if (!aged_) {
        if (!before.left.empty()) throw Error(ErrorCode::Conflict, "the method's frames stand alone");
        return;
    }
    before_ = LeftCells::decode(before.left, buckets_);
    followed_.follow(before.left);
}

std::optional<AgedCells> CellsBetweenFrames::aged(uint64_t seed) const {
    if (!aged_) return std::nullopt;
    return AgedCells(before_, age_, hash32(cache_key(seed, {})));
}

void CellsBetweenFrames::place(CellGrid& grid) const {
    if (before_.cells.empty()) return;
    grid.origin = before_.origin, grid.coarsest_m = before_.coarsest_m;
}

void CellsBetweenFrames::append(LeftCells& to, uint32_t slot, uint32_t fingerprint, const vec3& radiance,
                                uint32_t samples, uint32_t last_round) const {
    const uint32_t unseen = frames_unseen_by(last_round, age_);
    if (fingerprint == 0 || samples == 0 || unseen >= age_) return;
    to.cells.push_back({slot / RadianceCells::kSlots, fingerprint, radiance, samples, unseen});
}

}  // namespace photond
