// Speed of the GPU's sums and sorts (prefix_sum.h, radix_sort.h) by the device's own clock: seconds, elements a second,
// and bytes a second for the bytes the headers say an element takes. Prints a table; every result is first held against
// the host's. Medians of seven runs.
//
// Usage: gpu_primitives_bench [device [elements ...]]; "gpu", 100000 and 1000000 without arguments.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <random>
#include <stdexcept>

#include "renderer/backends/gpu/prefix_sum.h"
#include "renderer/backends/gpu/radix_sort.h"

namespace photond::gpu {
namespace {

using Words = std::vector<uint32_t>;
constexpr int kRuns = 7;
constexpr double kPrefixSumBytes = 12, kPassBytes = 21;

/// Runs what record(commands) records in a scope of its own.
template <class Record>
double median_seconds(Device& device, const Record& record) {
    std::vector<double> seconds;
    for (int run = 0; run < kRuns; ++run) {
        CommandList commands(device);
        record(commands);
        commands.submit();
        commands.wait();
        seconds.push_back(commands.times().front().seconds);
    }
    std::nth_element(seconds.begin(), seconds.begin() + kRuns / 2, seconds.end());
    return seconds[kRuns / 2];
}

void print(const char* what, size_t elements, double seconds, double bytes) {
    std::printf("%-22s %10zu elements %9.3f ms %9.1f M elements/s %8.1f GB/s\n", what, elements, 1e3 * seconds,
                1e-6 * double(elements) / seconds, 1e-9 * double(elements) * bytes / seconds);
}

void check(bool right) {
    if (!right) throw std::runtime_error("the device's result is wrong");
}

void measure(Device& device, uint32_t elements) {
    std::mt19937 random(1);
    Words keys(elements), places(elements);
    for (uint32_t& key : keys) key = static_cast<uint32_t>(random());
    std::iota(places.begin(), places.end(), 0u);
    Buffer key_buffer = make_buffer(device, "bench keys", std::span<const uint32_t>(keys));
    Buffer place_buffer = make_buffer(device, "bench values", std::span<const uint32_t>(places));
    Buffer count = make_buffer(device, "bench count", std::span<const uint32_t>(&elements, 1));
    Buffer total(device, "bench total", 4), to_keys(device, "bench keys", key_buffer.bytes()),
        to_places(device, "bench values", key_buffer.bytes());

    PrefixSum prefix_sum(device, elements);
    const double sum_seconds = median_seconds(device, [&](CommandList& commands) {
        const Scope scope(commands, "prefix_sum");
        prefix_sum.record(commands, key_buffer, to_keys, count, total);
    });
    Words expected(elements);
    std::exclusive_scan(keys.begin(), keys.end(), expected.begin(), 0u);
    check(read_back<uint32_t>(device, to_keys, elements) == expected);
    print("prefix sum", elements, sum_seconds, kPrefixSumBytes);

    RadixSort radix_sort(device, elements);
    for (const uint32_t bits : {16u, 32u}) {
        const double seconds = median_seconds(device, [&](CommandList& commands) {
            commands.copy(key_buffer, 0, to_keys, 0, key_buffer.bytes());
            commands.copy(place_buffer, 0, to_places, 0, key_buffer.bytes());
            const Scope scope(commands, "radix_sort");
            radix_sort.record(commands, to_keys, to_places, count, bits);
        });
        const uint32_t mask = ~0u >> (32 - bits);
        Words sorted = places;
        std::stable_sort(sorted.begin(), sorted.end(),
                         [&](uint32_t a, uint32_t b) { return (keys[a] & mask) < (keys[b] & mask); });
        check(read_back<uint32_t>(device, to_places, elements) == sorted);
        print(bits == 16 ? "radix sort, 16 bits" : "radix sort, 32 bits", elements, seconds,
              kPassBytes * (bits == 16 ? 2 : 4));
    }
}

}  // namespace
}  // namespace photond::gpu

int main(int argc, char** argv) try {
    photond::gpu::DeviceOptions options;
    if (argc > 1) options.id = argv[1];
    photond::gpu::Device device(options);
    std::printf("%s\n", device.report().name.c_str());
    std::vector<uint32_t> lengths;
    for (int i = 2; i < argc; ++i) lengths.push_back(static_cast<uint32_t>(std::strtoul(argv[i], nullptr, 10)));
    if (lengths.empty()) lengths = {100'000, 1'000'000};
    for (const uint32_t length : lengths) photond::gpu::measure(device, length);
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
