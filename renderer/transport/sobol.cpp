#include "renderer/transport/sobol.h"

#include <cassert>

namespace photond {

namespace {

/// Product in the field of four elements, numbered so that addition is exclusive or (2 is a root of x^2 + x + 1).
constexpr uint32_t multiply_gf4(uint32_t a, uint32_t b) {
    const uint32_t product = ((b & 1) ? a : 0u) ^ ((b & 2) ? a << 1 : 0u);
    return (product & 4) ? product ^ 7 : product;
}

/// Generator matrices, by column: bit r of columns[dimension][c] is the entry of row r, row 0 making the most
/// significant bit.
struct Generators {
    uint32_t columns[4][32] = {};
};

/// Dimension a of Faure's sequence over GF(4) has the digit matrix C(i, j) a^(i-j) (row j, column i; C(i, j) is odd
/// where the bits of j are among those of i). An entry e becomes the 2 x 2 bit matrix of x -> e x, with the digit's
/// bits of the odd dimensions recombined (first x0 + x1, then x0): that choice alone makes (0, 1) and (2, 3)
/// (0,2)-sequences in base 2 as well; found by search, checked by sobol_test.
constexpr Generators make_generators() {
    Generators generators;
    for (uint32_t a = 0; a < 4; ++a)
        for (uint32_t i = 0; i < 16; ++i)
            for (uint32_t j = 0; j <= i; ++j) {
                if ((i & j) != j) continue;
                uint32_t element = 1;
                for (uint32_t k = j; k < i; ++k) element = multiply_gf4(element, a);
                for (uint32_t bit = 0; bit < 2; ++bit) {
                    const uint32_t digit = multiply_gf4(element, 1u << bit);
                    const uint32_t first = (a & 1) ? (digit ^ (digit >> 1)) & 1 : digit & 1;
                    const uint32_t second = (a & 1) ? digit & 1 : digit >> 1;
                    generators.columns[a][2 * i + bit] |= (first | second << 1) << (2 * j);
                }
            }
    return generators;
}

constexpr Generators kGenerators = make_generators();

/// Bits of one coordinate of the sequence, the most significant lowest.
constexpr uint32_t point_bits_reversed(uint32_t index, uint32_t dimension) {
    uint32_t bits = 0;
    for (uint32_t c = 0; index != 0; ++c, index >>= 1)
        if (index & 1) bits ^= kGenerators.columns[dimension][c];
    return bits;
}

}  // namespace

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
    const uint64_t salts = hash64(uint64_t{set_salt_} << 32 | set);
    // Nested uniform shuffle of the index [Burley 2020, sec. 3.2], the same for both sets of a block.
    const uint32_t shuffle_seed = static_cast<uint32_t>(hash64(~(uint64_t{set_salt_} << 32 | set / 2)) >> 32);
    const uint32_t index = reverse_bits(laine_karras(reverse_bits(pass_), shuffle_seed));
    const uint32_t dimension = 2 * (set % 2);
    return {.x_reversed = point_bits_reversed(index, dimension),
            .y_reversed = point_bits_reversed(index, dimension + 1),
            .x_salt = static_cast<uint32_t>(salts >> 32),
            .y_salt = static_cast<uint32_t>(salts)};
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
    // Two plain loops: each vectorises to the machine's width.
    for (size_t i = 0; i < count; ++i) xs[i] = scramble_bits(point.x_reversed, hash32(keys[i] ^ point.x_salt));
    for (size_t i = 0; i < count; ++i) ys[i] = scramble_bits(point.y_reversed, hash32(keys[i] ^ point.y_salt));
}

}  // namespace photond
