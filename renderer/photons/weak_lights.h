#pragma once
// Lights that would have less than one of a map's texels take turns from pass to pass.

#include <vector>

#include "renderer/core/rng.h"

namespace photond {

/// What a map's pass draws, beside its texels' numbers: a pure function of (seed, pass, stream).
struct MapPassNumbers {
    MapPassNumbers(uint64_t seed, uint32_t pass, uint64_t stream) {
        RandomStream random(seed, RandomDomain::Photons, pass, stream);
        const auto bits = [&] { return uint64_t{random.next_bits()} << 32 | random.next_bits(); };
        texel_seed = bits();
        offset = static_cast<double>(bits() >> 11) * 0x1p-53;
        rotation.x = random.next_bits();
        rotation.y = random.next_bits();
    }

    uint64_t texel_seed;  // passes share no numbers, as the same texels come in each
    double offset;        // in [0, 1)
    uvec2 rotation;       // of a point set
};

/// choose(light) for some of them, by systematic sampling: equidistant points with one offset on the cumulative sum of
/// their `expected` texels, each below 1. A light is met exactly as often as expected, and the number of all hardly
/// varies.
template <class Light, class Choose>
void take_turns(const std::vector<Light>& weak, double offset, const Choose& choose) {
    double sum = 0, next = offset;
    for (const Light& light : weak) {
        sum += double{light.expected};
        if (next >= sum) continue;
        next += 1;
        choose(light);
    }
}

}  // namespace photond
