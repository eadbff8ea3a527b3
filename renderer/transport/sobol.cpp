#include "renderer/transport/sobol.h"

#include <cassert>

namespace photond {

namespace {

constexpr uint32_t kDimensions = 2 * PassSampler::kSetsInBlock;

/// Primitive polynomial (degree, inner coefficients) and initial direction numbers of a dimension.
/// [Joe and Kuo 2008], file new-joe-kuo-6.21201.
struct JoeKuo {
    uint32_t degree;
    uint32_t coefficients;
    uint32_t initial[7];
};
constexpr JoeKuo kJoeKuo[kDimensions - 1] = {
    {1, 0, {1}},
    {2, 1, {1, 3}},
    {3, 1, {1, 3, 1}},
    {3, 2, {1, 1, 1}},
    {4, 1, {1, 1, 3, 3}},
    {4, 4, {1, 3, 5, 13}},
    {5, 2, {1, 1, 5, 5, 17}},
    {5, 4, {1, 1, 5, 5, 5}},
    {5, 7, {1, 1, 7, 11, 19}},
    {5, 11, {1, 1, 5, 1, 1}},
    {5, 13, {1, 1, 1, 3, 11}},
    {5, 14, {1, 3, 5, 5, 31}},
    {6, 1, {1, 3, 3, 9, 7, 49}},
    {6, 13, {1, 1, 1, 15, 21, 21}},
    {6, 16, {1, 3, 1, 13, 27, 49}},
    {6, 19, {1, 1, 1, 15, 7, 5}},
    {6, 22, {1, 3, 1, 15, 13, 25}},
    {6, 25, {1, 1, 5, 5, 19, 61}},
    {7, 1, {1, 3, 7, 11, 23, 15, 103}},
};

/// Direction numbers by dimension and index bit, bits reversed: bit 0 is the most significant of the fraction.
struct Directions {
    uint32_t reversed[kDimensions][32] = {};
};
constexpr Directions make_directions() {
    Directions directions;
    for (uint32_t bit = 0; bit < 32; ++bit) directions.reversed[0][bit] = 1u << bit;
    for (uint32_t d = 1; d < kDimensions; ++d) {
        const JoeKuo& row = kJoeKuo[d - 1];
        uint32_t v[32] = {};
        for (uint32_t bit = 0; bit < 32; ++bit) {
            if (bit < row.degree) {
                v[bit] = row.initial[bit] << (31 - bit);
                continue;
            }
            v[bit] = v[bit - row.degree] ^ (v[bit - row.degree] >> row.degree);
            for (uint32_t k = 1; k < row.degree; ++k)
                if (row.coefficients >> (row.degree - 1 - k) & 1) v[bit] ^= v[bit - k];
        }
        for (uint32_t bit = 0; bit < 32; ++bit) directions.reversed[d][bit] = sobol_detail::reverse_bits(v[bit]);
    }
    return directions;
}
constexpr Directions kDirections = make_directions();

/// One coordinate of the sequence, the most significant bit lowest.
uint32_t point_bits_reversed(uint32_t index, uint32_t dimension) {
    uint32_t bits = 0;
    for (uint32_t bit = 0; index != 0; ++bit, index >>= 1)
        if (index & 1) bits ^= kDirections.reversed[dimension][bit];
    return bits;
}

float scrambled_fraction(uint32_t bits_reversed, uint32_t seed) {
    return to_unit_float(sobol_detail::reverse_bits(sobol_detail::laine_karras(bits_reversed, seed)));
}

}  // namespace

std::span<const uint32_t> sobol_directions() {
    static_assert(kDimensions == SOBOL_DIMENSIONS);
    return {&kDirections.reversed[0][0], kDimensions * SOBOL_INDEX_BITS};
}

PassSampler::PassSampler(SamplerKind kind, uint64_t seed, RandomDomain domain, uint32_t pass)
    : kind_(kind), pass_(pass) {
    const uint64_t stream = hash64(hash64(seed + 0x9e3779b97f4a7c15ull) ^ static_cast<uint64_t>(domain));
    set_salt_ = static_cast<uint32_t>(stream >> 32);
    pixel_salt_ = static_cast<uint32_t>(stream);
    random_key_ = hash64(stream + (uint64_t{pass} << 32 | 1u));
    if (kind == SamplerKind::Random) return;
    prepared_.reserve(kPreparedSets);
    for (uint32_t set = 0; set < kPreparedSets; ++set) prepared_.push_back(make_set_point(set));
}

PassSampler::SetPoint PassSampler::make_set_point(uint32_t set) const {
    using namespace sobol_detail;
    // Nested uniform shuffle of the index [Burley 2020, sec. 3.2], the same for all sets of a block.
    const uint32_t block = set / kSetsInBlock;
    const uint32_t shuffle_seed = static_cast<uint32_t>(hash64(~(uint64_t{set_salt_} << 32 | block)) >> 32);
    const uint32_t index = reverse_bits(laine_karras(reverse_bits(pass_), shuffle_seed));
    const uint32_t dimension = 2 * (set % kSetsInBlock);
    return {.x_reversed = point_bits_reversed(index, dimension),
            .y_reversed = point_bits_reversed(index, dimension + 1),
            .salt = hash64(uint64_t{set_salt_} << 32 | set)};
}

void PassSampler::sample_2d(std::span<const uint32_t> pixel_keys, uint32_t set, std::span<float> x,
                            std::span<float> y) const {
    assert(x.size() == pixel_keys.size() && y.size() == pixel_keys.size());
    const size_t count = pixel_keys.size();
    const uint32_t* keys = pixel_keys.data();
    float* xs = x.data();
    float* ys = y.data();
    if (kind_ == SamplerKind::Random) {
        for (size_t i = 0; i < count; ++i) {
            const vec2 p = random_point(keys[i], set);
            xs[i] = p.x;
            ys[i] = p.y;
        }
        return;
    }
    const SetPoint point = set < kPreparedSets ? prepared_[set] : make_set_point(set);
    for (size_t i = 0; i < count; ++i) {
        const vec2 p = scramble(point, keys[i]);
        xs[i] = p.x;
        ys[i] = p.y;
    }
}

gpu::PassSamplerData PassSampler::device_data() const {
    gpu::PassSamplerData data{static_cast<uint32_t>(kind_), pass_, set_salt_, pixel_salt_, random_key_, {}};
    for (size_t set = 0; set < prepared_.size(); ++set)
        data.prepared[set] = {prepared_[set].x_reversed, prepared_[set].y_reversed, prepared_[set].salt};
    return data;
}

SequenceSampler::SequenceSampler(SamplerKind kind, uint64_t seed, RandomDomain domain, uint32_t stream)
    : kind_(kind),
      key_(hash64(hash64(hash64(seed + 0x9e3779b97f4a7c15ull) ^ static_cast<uint64_t>(domain)) ^
                  (uint64_t{stream} << 32 | static_cast<uint64_t>(kind)))) {}

vec2 SequenceSampler::sample_2d(uint64_t index, uint32_t set) const {
    if (is_random(set)) return random_point(set_key(set), index);
    const uint64_t seeds = scramble_seeds(index, set);
    const auto low = static_cast<uint32_t>(index);
    return {scrambled_fraction(point_bits_reversed(low, 2 * set), static_cast<uint32_t>(seeds >> 32)),
            scrambled_fraction(point_bits_reversed(low, 2 * set + 1), static_cast<uint32_t>(seeds))};
}

void SequenceSampler::sample_2d(uint64_t run, std::span<const uint32_t> offsets, uint32_t set, std::span<float> x,
                                std::span<float> y) const {
    assert(x.size() == offsets.size() && y.size() == offsets.size());
    const size_t count = offsets.size();
    const uint64_t first = run * kRun;
    const uint32_t* elements = offsets.data();
    float* xs = x.data();
    float* ys = y.data();
    if (is_random(set)) {
        const uint64_t key = set_key(set);
        for (size_t i = 0; i < count; ++i) {
            const vec2 p = random_point(key, first + elements[i]);
            xs[i] = p.x;
            ys[i] = p.y;
        }
        return;
    }
    const uint64_t seeds = scramble_seeds(first, set);
    const auto draw = [&](uint32_t dimension, uint32_t seed, float* out) {
        // The whole run's coordinates: each bit of the offset doubles what is known.
        uint32_t bits[kRun];
        bits[0] = point_bits_reversed(static_cast<uint32_t>(first), dimension);
        for (uint32_t bit = 0, known = 1; known < kRun; ++bit, known *= 2) {
            const uint32_t direction = kDirections.reversed[dimension][bit];
            for (uint32_t k = 0; k < known; ++k) bits[known + k] = bits[k] ^ direction;
        }
        for (size_t i = 0; i < count; ++i) out[i] = scrambled_fraction(bits[elements[i]], seed);
    };
    draw(2 * set, static_cast<uint32_t>(seeds >> 32), xs);
    draw(2 * set + 1, static_cast<uint32_t>(seeds), ys);
}

}  // namespace photond
