// The GLSL twins of core: the same random numbers bit for bit, the same frames and offsets.

#include <gtest/gtest.h>

#include "renderer/core/rng.h"
#include "tests/support/gpu_twin.h"

namespace photond::gpu_twins_core_test {
namespace {

using namespace test;

struct Stream {
    uint64_t seed;
    uint64_t stream;
    uint32_t domain;
    uint32_t pass;
};
struct Numbers {
    uint64_t hash;
    uint32_t bits[3];
    vec2 point;
    uint32_t hash_of_bits;
};
static_assert(sizeof(Stream) == 24 && sizeof(Numbers) == 32, "must match random_stream.comp");

TEST(GpuTwinsCore, RandomStreamsAreTheSameNumbers) {
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<Stream> streams(1000);
    for (Stream& s : streams) {
        s.seed = uint64_t{random.next_bits()} << 32 | random.next_bits();
        s.stream = uint64_t{random.next_bits()} << 32 | random.next_bits();
        s.domain = 1 + random.next_bits() % 8;
        s.pass = random.next_bits() >> (random.next_bits() % 32);
    }
    const auto numbers = run_twin<Numbers>("tests/gpu/random_stream.comp", streams.size(), {{"streams", streams}});
    for (size_t i = 0; i < streams.size(); ++i) {
        const Stream& s = streams[i];
        RandomStream expected(s.seed, RandomDomain(s.domain), s.pass, s.stream);
        EXPECT_EQ(numbers[i].hash, hash64(s.seed));
        for (const uint32_t bits : numbers[i].bits) EXPECT_EQ(bits, expected.next_bits());
        EXPECT_EQ(numbers[i].point, expected.next_2d());
        EXPECT_EQ(numbers[i].hash_of_bits, hash32(numbers[i].bits[0]));
    }
}

}  // namespace
}  // namespace photond::gpu_twins_core_test
