#pragma once
// The numbers a pass draws: low-discrepancy across the passes of a pixel, independent between pixels, and a pure
// function of (seed, domain, pixel, pass, set), so that passes can be rendered in any order and merged.
//
// Each two-dimensional set is the (0,2)-sequence of Sobol' and van der Corput, taken in an order shuffled for that set
// and Owen-scrambled for that set and pixel; the passes are its index. The shuffle keeps blocks of 2^k indices
// together, so the first 2^k passes of a pixel are a (0,2)-net in every set. It is the same for all pixels: all the
// work on the index is done once a pass, and a pixel pays for the scrambling alone.
//
// [Owen 1995] Randomly Permuted (t,m,s)-Nets and (t,s)-Sequences.
// [Kollig and Keller 2002] Efficient Multidimensional Sampling (padding of sets).
// [Burley 2020] Practical Hash-Based Owen Scrambling. JCGT 9(4).
// [Laine and Karras 2011] Stratified Sampling for Stochastic Transparency (the scrambling hash).

#include <span>
#include <vector>

#include "renderer/core/rng.h"

namespace photond {

/// Where numbers come from: Random is the same interface over independent numbers, to be compared with.
enum class SamplerKind : uint8_t { Sobol, Random };

/// The numbers of one pass. Built once a pass, then read by all threads. Sets are numbered by the caller, one for each
/// two-dimensional decision along a path; the first kPreparedSets are the fastest, all others work as well.
class PassSampler {
public:
    static constexpr uint32_t kPreparedSets = 128;

    PassSampler(SamplerKind kind, uint64_t seed, RandomDomain domain, uint32_t pass);

    /// Names a pixel's streams; different pixels never share one. Compute once a path.
    uint32_t pixel_key(uint32_t pixel) const { return hash32(pixel ^ pixel_salt_); }

    /// A point in [0, 1)^2.
    vec2 sample_2d(uint32_t pixel_key, uint32_t set) const;

    /// The same for many pixels at once, vectorised: (x[i], y[i]) is sample_2d(pixel_keys[i], set). Spans of equal
    /// length.
    void sample_2d(std::span<const uint32_t> pixel_keys, uint32_t set, std::span<float> x, std::span<float> y) const;

private:
    /// What a set has in common for all pixels of this pass.
    struct SetPoint {
        uint32_t x_reversed;  // bits of the unscrambled point, lowest first
        uint32_t y_reversed;
        uint32_t x_salt;  // told apart from other sets by these
        uint32_t y_salt;
    };
    SetPoint make_set_point(uint32_t set) const;

    SamplerKind kind_;
    uint32_t pass_;
    uint32_t set_salt_;
    uint32_t pixel_salt_;
    uint64_t random_key_;
    std::vector<SetPoint> prepared_;  // empty for SamplerKind::Random
};

}  // namespace photond
