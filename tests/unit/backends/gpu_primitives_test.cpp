// Sums and sorts of the GPU against the same by the standard library, bit for bit.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "renderer/backends/gpu/prefix_sum.h"
#include "renderer/backends/gpu/radix_sort.h"
#include "tests/support/gpu_twin.h"

namespace photond::gpu::gpu_primitives_test {
namespace {

using Words = std::vector<uint32_t>;

constexpr uint32_t kCapacity = 120'000;
constexpr uint32_t kBeyond = 64;             // words past the capacity, which nothing may touch
constexpr uint32_t kUntouched = 0xdeadbeef;  // what is in them

Buffer make(const Words& words) { return make_buffer(test::gpu_device(), "test words", std::span(words)); }

void run(CommandList& commands) {
    commands.submit();
    commands.wait();
}

Words random_words(size_t count, uint32_t seed, uint32_t mask = ~0u) {
    std::mt19937 random(seed);
    Words words(count);
    for (uint32_t& word : words) word = static_cast<uint32_t>(random()) & mask;
    return words;
}

/// Warps of the device's subgroups, which keep in step by themselves; others, which need the group's barriers.
class GpuPrimitives : public testing::TestWithParam<uint32_t> {
protected:
    const GroupShape shape_{test::gpu_device(), GetParam()};

    Words lengths() const {
        return {0,
                1,
                shape_.threads() - 1,
                shape_.threads(),
                shape_.threads() + 1,
                shape_.tile() - 1,
                shape_.tile(),
                shape_.tile() + 1,
                17 * shape_.tile(),  // of the sums of tiles, which are summed by the tile, more than a thread's
                100'003,
                kCapacity};
    }
};

INSTANTIATE_TEST_SUITE_P(Warps, GpuPrimitives, testing::Values(0, 32));

TEST_P(GpuPrimitives, PrefixSumsAreThoseOfTheHostForEveryLength) {
    Device& device = test::gpu_device();
    PrefixSum prefix_sum(device, kCapacity, GetParam());
    for (const uint32_t length : lengths()) {
        SCOPED_TRACE(length);
        Words words = random_words(kCapacity + kBeyond, length);  // their sums pass 2^32
        Buffer in = make(words), out = make(Words(words.size(), kUntouched));
        Buffer counts = make({7, length}), totals = make({kUntouched, kUntouched, kUntouched});
        CommandList commands(device);
        prefix_sum.record(commands, in, out, {counts, 1}, {totals, 2});
        run(commands);

        Words expected(words.size(), kUntouched);
        std::exclusive_scan(words.begin(), words.begin() + length, expected.begin(), 0u);
        EXPECT_EQ(read_back<uint32_t>(device, out, words.size()), expected);
        const uint32_t total = std::accumulate(words.begin(), words.begin() + length, 0u);
        EXPECT_EQ(read_back<uint32_t>(device, totals, 3), (Words{kUntouched, kUntouched, total}));
        EXPECT_EQ(read_back<uint32_t>(device, in, words.size()), words);
    }
}

TEST_P(GpuPrimitives, PrefixSumsMayReplaceTheirWords) {
    Device& device = test::gpu_device();
    PrefixSum prefix_sum(device, kCapacity, GetParam());
    const Words words = random_words(100'003, 1);
    Buffer buffer = make(words), count = make({100'003}), total = make({0});
    CommandList commands(device);
    prefix_sum.record(commands, buffer, buffer, count, total);
    run(commands);
    Words expected(words.size());
    std::exclusive_scan(words.begin(), words.end(), expected.begin(), 0u);
    EXPECT_EQ(read_back<uint32_t>(device, buffer, words.size()), expected);
}

TEST_P(GpuPrimitives, CountsPastTheCapacityAreTheCapacity) {
    Device& device = test::gpu_device();
    constexpr uint32_t kFew = 5000;
    PrefixSum prefix_sum(device, kFew, GetParam());
    RadixSort radix_sort(device, kFew, GetParam());
    Words words(kFew + kBeyond, 1), keys = random_words(kFew + kBeyond, 3), values(keys.size(), 9);
    Buffer sums = make(words), key_buffer = make(keys), value_buffer = make(values);
    Buffer count = make({0xffffffff}), total = make({0});
    CommandList commands(device);
    prefix_sum.record(commands, sums, sums, count, total);
    radix_sort.record(commands, key_buffer, value_buffer, count, 32);
    run(commands);
    EXPECT_EQ(read_back<uint32_t>(device, total, 1), Words{kFew});
    std::iota(words.begin(), words.begin() + kFew, 0u);
    EXPECT_EQ(read_back<uint32_t>(device, sums, words.size()), words);
    std::sort(keys.begin(), keys.begin() + kFew);
    EXPECT_EQ(read_back<uint32_t>(device, key_buffer, keys.size()), keys);
}

/// What RadixSort makes of keys whose values are their places, against std::stable_sort.
void expect_sorted(RadixSort& radix_sort, const Words& keys, uint32_t length, uint32_t key_bits) {
    Device& device = test::gpu_device();
    Words places(keys.size());
    std::iota(places.begin(), places.end(), 0u);
    Buffer key_buffer = make(keys), value_buffer = make(places), count = make({7, 7, length});
    CommandList commands(device);
    radix_sort.record(commands, key_buffer, value_buffer, {count, 2}, key_bits);
    run(commands);
    const uint32_t mask = ~0u >> (32 - key_bits);
    std::stable_sort(places.begin(), places.begin() + length,
                     [&](uint32_t a, uint32_t b) { return (keys[a] & mask) < (keys[b] & mask); });
    Words sorted(keys.size());
    for (size_t i = 0; i < keys.size(); ++i) sorted[i] = keys[places[i]];
    EXPECT_EQ(read_back<uint32_t>(device, key_buffer, keys.size()), sorted);
    EXPECT_EQ(read_back<uint32_t>(device, value_buffer, keys.size()), places);
}

TEST_P(GpuPrimitives, SortsAreStableForEveryLength) {
    RadixSort radix_sort(test::gpu_device(), kCapacity, GetParam());
    // Few enough different keys that order among equal ones shows at once.
    const Words keys = random_words(kCapacity + kBeyond, 2, 0x80300f01);
    for (const uint32_t length : lengths()) {
        SCOPED_TRACE(length);
        expect_sorted(radix_sort, keys, length, 32);
    }
}

TEST_P(GpuPrimitives, SortsLookAtTheKeyBitsTheyAreTold) {
    RadixSort radix_sort(test::gpu_device(), kCapacity, GetParam());
    const Words keys = random_words(20'000, 4);
    for (const uint32_t bits : {1, 2, 7, 8, 9, 16, 17, 23, 31, 32}) {
        SCOPED_TRACE(bits);
        expect_sorted(radix_sort, keys, 20'000, bits);
    }
    Buffer words = make({1}), count = make({1});
    CommandList commands(test::gpu_device());
    EXPECT_THROW(radix_sort.record(commands, words, words, count, 0), Error);
    EXPECT_THROW(radix_sort.record(commands, words, words, count, 33), Error);
}

TEST_P(GpuPrimitives, SortsOfEqualOfOrderedAndOfReversedKeys) {
    RadixSort radix_sort(test::gpu_device(), kCapacity, GetParam());
    constexpr uint32_t kLength = 30'011;
    Words keys(kLength, 0xa5a5a5a5);
    expect_sorted(radix_sort, keys, kLength, 32);
    for (uint32_t i = 0; i < kLength; ++i) keys[i] = 0xffffffff - 40'009 * (kLength - i);
    ASSERT_TRUE(std::is_sorted(keys.begin(), keys.end()));
    expect_sorted(radix_sort, keys, kLength, 32);
    std::reverse(keys.begin(), keys.end());
    expect_sorted(radix_sort, keys, kLength, 32);
}

TEST_P(GpuPrimitives, RunAgainFromOneListTheBitsAreTheSame) {
    Device& device = test::gpu_device();
    RadixSort radix_sort(device, kCapacity, GetParam());
    PrefixSum prefix_sum(device, kCapacity, GetParam());
    const Words keys = random_words(50'000, 5, 0xfff), values = random_words(50'000, 6);
    Buffer from_keys = make(keys), from_values = make(values), count = make({50'000}), total = make({0});
    std::vector<Buffer> key_buffers, value_buffers;
    CommandList commands(device);
    for (int i = 0; i < 3; ++i) {  // one after the other through the same scratch
        Buffer& k = key_buffers.emplace_back(device, "test words", from_keys.bytes());
        Buffer& v = value_buffers.emplace_back(device, "test words", from_values.bytes());
        commands.copy(from_keys, 0, k, 0, from_keys.bytes());
        commands.copy(from_values, 0, v, 0, from_values.bytes());
        radix_sort.record(commands, k, v, count, 12);
        prefix_sum.record(commands, v, v, count, total);
    }
    run(commands);
    const Words first_keys = read_back<uint32_t>(device, key_buffers[0], keys.size());
    const Words first_sums = read_back<uint32_t>(device, value_buffers[0], keys.size());
    EXPECT_TRUE(std::is_sorted(first_keys.begin(), first_keys.end()));
    for (int i = 1; i < 3; ++i) {
        EXPECT_EQ(read_back<uint32_t>(device, key_buffers[size_t(i)], keys.size()), first_keys);
        EXPECT_EQ(read_back<uint32_t>(device, value_buffers[size_t(i)], keys.size()), first_sums);
    }
}

TEST(GpuPrimitivesMemory, ScratchIsAccountedByStructureAndGoesAway) {
    Device& device = test::gpu_device();
    const auto before = device.memory().structures();
    {
        RadixSort radix_sort(device, kCapacity);
        PrefixSum prefix_sum(device, kCapacity);
        auto during = device.memory().structures();
        const uint64_t tiles = (kCapacity + GroupShape(device).tile() - 1) / GroupShape(device).tile();
        // A driver may round a buffer up.
        constexpr uint64_t kSlack = 4096;
        EXPECT_NEAR(double(during["radix sort keys"]), 4.0 * kCapacity, kSlack);
        EXPECT_NEAR(double(during["radix sort values"]), 4.0 * kCapacity, kSlack);
        EXPECT_NEAR(double(during["radix sort counts"]), 1024.0 * double(tiles), kSlack);
        EXPECT_NEAR(double(during["prefix sum"]), 4.0 * double(tiles), kSlack);
    }
    EXPECT_EQ(device.memory().structures(), before);
}

TEST(GpuPrimitivesMemory, CapacitiesNoDispatchCanTakeAreRefused) {
    EXPECT_THROW(DeviceTiles(test::gpu_device(), "test tiles", (1u << 31) + 1, 1024), Error);
    EXPECT_THROW(GroupShape(test::gpu_device(), 12), Error);
    EXPECT_THROW(GroupShape(test::gpu_device(), 64), Error);
}

}  // namespace
}  // namespace photond::gpu::gpu_primitives_test
