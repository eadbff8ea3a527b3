#pragma once
// The numbers a pass draws: low-discrepancy across the passes of a pixel, independent between pixels, and a pure
// function of (seed, domain, pixel, pass, set), so that passes can be rendered in any order and merged.
//
// Sets of two dimensions come in blocks of ten: the coordinates of one twenty-dimensional Sobol' sequence, whose index
// is the pass, in an order shuffled for the block. Each coordinate is Owen-scrambled for the pixel. The shuffle keeps
// aligned runs of 2^k passes together, so each run is as well distributed as the sequence's own. It is the same for all
// pixels: the work on the index is done once a pass, and a pixel pays for the scrambling alone.
//
// The lower its number, the better a set is distributed together with the others of its block: give the first ten to
// the decisions of a path that most of the variance comes from, later blocks to the rest. Measured, path tracing of the
// Cornell box, 256 passes, relative_mse below independent numbers' by: 1.98 with direction and light of the first
// bounce first; 1.7 in the order of the path; 1.5 with independently shuffled blocks of two sets (padding, [Kollig and
// Keller 2002]).
//
// [Sobol' 1967] On the Distribution of Points in a Cube and the Approximate Evaluation of Integrals.
// [Joe and Kuo 2008] Constructing Sobol Sequences with Better Two-Dimensional Projections. SIAM J. Sci. Comput. 30.
// [Owen 1995] Randomly Permuted (t,m,s)-Nets and (t,s)-Sequences.
// [Kollig and Keller 2002] Efficient Multidimensional Sampling.
// [Burley 2020] Practical Hash-Based Owen Scrambling. JCGT 9(4).
// [Laine and Karras 2011] Stratified Sampling for Stochastic Transparency (the scrambling hash).

#include <algorithm>
#include <span>
#include <vector>

#include "renderer/core/rng.h"
#include "renderer/transport/sobol_shared.h"

namespace photond {

namespace sobol_detail {

constexpr uint32_t reverse_bits(uint32_t x) {
    x = (x >> 16) | (x << 16);
    x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

/// Owen scrambling of a fraction whose bits are given lowest first: bit b of the result depends on bits 0..b only.
/// [Laine and Karras 2011], constants of [Vegdahl 2021] "Building a Better LK Hash" as in pbrt-v4's FastOwenScrambler.
constexpr uint32_t laine_karras(uint32_t x, uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

}  // namespace sobol_detail

/// Where numbers come from: Random is the same interface over independent numbers, to be compared with.
enum class SamplerKind : uint8_t { Sobol, Random };
static_assert(int(SamplerKind::Sobol) == SAMPLER_KIND_SOBOL && int(SamplerKind::Random) == SAMPLER_KIND_RANDOM);

/// The generator matrices that sobol.glsl reads: a word for each dimension and bit of the index, the dimension's bits
/// together; bit 0 of a word is the most significant of the fraction.
std::span<const uint32_t> sobol_directions();

/// The numbers of one pass. Built once a pass, then read by all threads. Sets are numbered by the caller, one for each
/// two-dimensional decision along a path; the first kPreparedSets are the fastest, all others work as well.
class PassSampler {
public:
    static constexpr uint32_t kSetsInBlock = 10;
    static constexpr uint32_t kPreparedSets = 120;
    static_assert(kSetsInBlock == SOBOL_SETS_IN_BLOCK && kPreparedSets == SOBOL_PREPARED_SETS);

    PassSampler(SamplerKind kind, uint64_t seed, RandomDomain domain, uint32_t pass);

    /// Names a pixel's streams; different pixels never share one. Compute once a path.
    uint32_t pixel_key(uint32_t pixel) const { return hash32(pixel ^ pixel_salt_); }

    /// A point in [0, 1)^2.
    vec2 sample_2d(uint32_t pixel_key, uint32_t set) const {
        if (kind_ == SamplerKind::Random) return random_point(pixel_key, set);
        return scramble(set < kPreparedSets ? prepared_[set] : make_set_point(set), pixel_key);
    }

    /// The same for many pixels at once, vectorised: (x[i], y[i]) is sample_2d(pixel_keys[i], set), bit by bit. Spans
    /// of equal length.
    void sample_2d(std::span<const uint32_t> pixel_keys, uint32_t set, std::span<float> x, std::span<float> y) const;

    /// For the twin in sobol.glsl, which draws the same numbers.
    gpu::PassSamplerData device_data() const;

private:
    /// What a set has in common for all pixels of this pass.
    struct SetPoint {
        uint32_t x_reversed;  // bits of the unscrambled point, lowest first
        uint32_t y_reversed;
        uint64_t salt;  // of the set
    };
    SetPoint make_set_point(uint32_t set) const;

    static float scramble_bits(uint32_t reversed, uint32_t seed) {
        return to_unit_float(sobol_detail::reverse_bits(sobol_detail::laine_karras(reversed, seed)));
    }
    static vec2 scramble(const SetPoint& point, uint32_t pixel_key) {
        // Both seeds from one 64-bit hash: those of hash32, salted by set, are correlated between sets (sobol_test).
        const uint64_t seeds = hash64(point.salt + pixel_key);
        return {scramble_bits(point.x_reversed, static_cast<uint32_t>(seeds >> 32)),
                scramble_bits(point.y_reversed, static_cast<uint32_t>(seeds))};
    }
    vec2 random_point(uint32_t pixel_key, uint32_t set) const {
        const uint64_t bits = hash64((uint64_t{pixel_key} << 32 | set) ^ random_key_);
        return {to_unit_float(static_cast<uint32_t>(bits >> 32)), to_unit_float(static_cast<uint32_t>(bits))};
    }

    SamplerKind kind_;
    uint32_t pass_;
    uint32_t set_salt_;  // of the seed and the domain, as is pixel_salt_
    uint32_t pixel_salt_;
    uint64_t random_key_;
    std::vector<SetPoint> prepared_;  // empty for SamplerKind::Random
};

/// Numbers along one long sequence: element after element of it, not pixel after pixel of one element. For light paths,
/// whose index counts on from pass to pass: any stretch of the sequence covers all lights and directions evenly.
///
/// The first kSets two-dimensional sets are the coordinates of one twenty-dimensional Sobol' sequence, each
/// Owen-scrambled as a whole; all sets beyond are independent numbers. Lower sets are distributed better. After 2^32
/// elements the sequence starts again, scrambled anew. A pure function of (seed, domain, stream, index, set).
class SequenceSampler {
public:
    static constexpr uint32_t kSets = PassSampler::kSetsInBlock;
    /// Elements of an aligned run, which are drawn together: they share all but the lowest bits of their index.
    static constexpr uint32_t kRun = 1024;

    /// `stream`: sequences of the same seed and domain that must not share numbers.
    SequenceSampler(SamplerKind kind, uint64_t seed, RandomDomain domain, uint32_t stream);

    /// A point in [0, 1)^2.
    vec2 sample_2d(uint64_t index, uint32_t set) const;

    /// The same for many elements of one run, vectorised: (x[i], y[i]) is sample_2d(run * kRun + offsets[i], set), bit
    /// by bit. Offsets below kRun; spans of equal length.
    void sample_2d(uint64_t run, std::span<const uint32_t> offsets, uint32_t set, std::span<float> x,
                   std::span<float> y) const;

    /// For the twin in sobol.glsl, which draws the same numbers.
    gpu::SequenceKey device_key() const { return {key_, static_cast<uint32_t>(kind_), 0}; }

private:
    bool is_random(uint32_t set) const { return kind_ == SamplerKind::Random || set >= kSets; }
    /// Seeds of both coordinates' scrambling, x in the upper half.
    uint64_t scramble_seeds(uint64_t index, uint32_t set) const { return hash64(set_key(set) + ~(index >> 32)); }
    uint64_t set_key(uint32_t set) const { return hash64(key_ + set); }
    static vec2 random_point(uint64_t set_key, uint64_t index) {
        const uint64_t bits = hash64(set_key + index * 0x9e3779b97f4a7c15ull);
        return {to_unit_float(static_cast<uint32_t>(bits >> 32)), to_unit_float(static_cast<uint32_t>(bits))};
    }

    SamplerKind kind_;
    uint64_t key_;
};

/// Elements that are drawn together: part of one run.
struct SequenceRun {
    uint64_t run;
    uint32_t first, last;  // elements of the run, half open
};

/// A stretch of the sequence, cut where its runs are.
struct SequenceRuns {
    uint64_t first, last;  // elements, half open

    size_t count() const { return static_cast<size_t>((last + kRun - 1) / kRun - first / kRun); }
    SequenceRun operator[](size_t i) const {
        const uint64_t run = first / kRun + i, start = run * kRun;
        return {run, static_cast<uint32_t>(std::max(first, start) - start),
                static_cast<uint32_t>(std::min(last - start, kRun))};
    }

private:
    static constexpr uint64_t kRun = SequenceSampler::kRun;
};

}  // namespace photond
