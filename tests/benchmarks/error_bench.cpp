// What measuring an image against its reference costs: nanoseconds a pixel, on as many threads as the machine has or as
// TBB is told (taskset limits them).
//
// A render job calls `pointwise` at every point of its curve, the others when they are asked for by name.
//
// Usage: error_bench [--benchmark_filter=pointwise] and whatever else Google Benchmark knows.

#include <benchmark/benchmark.h>

#include <cmath>

#include "renderer/core/rng.h"
#include "renderer/error/error_meter.h"

namespace photond {
namespace {

/// A reference over three magnitudes, and an image of it as noisy as after a few passes.
struct Images {
    Size2 size;
    std::vector<float> reference, image;

    explicit Images(const benchmark::State& state)
        : size{static_cast<uint32_t>(state.range(0)), static_cast<uint32_t>(state.range(1))} {
        RandomStream random(1, RandomDomain::Test, 0, 0);
        for (size_t i = 0; i < 3 * size.pixels(); ++i) {
            reference.push_back(std::exp(7 * random.next() - 5));
            image.push_back(reference.back() * (0.5f + random.next()));
        }
    }
};

template <class Measure>
void run(benchmark::State& state, const Measure& measure) {
    const Images images(state);
    const ErrorMeter meter(images.size, images.reference);
    measure(meter, images.image);  // what is made when first asked for
    for (auto _ : state) benchmark::DoNotOptimize(measure(meter, images.image));
    state.counters["s_per_pixel"] = benchmark::Counter(double(state.iterations()) * double(images.size.pixels()),
                                                       benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void pointwise(benchmark::State& state) {
    run(state, [](const ErrorMeter& meter, const auto& image) { return meter.pointwise(image)[Metric::Rmse]; });
}
void percentiles(benchmark::State& state) {
    run(state, [](const ErrorMeter& meter, const auto& image) { return meter.percentiles(image); });
}
void fireflies(benchmark::State& state) {
    run(state, [](const ErrorMeter& meter, const auto& image) { return meter.firefly_count(image); });
}
void flip_ldr(benchmark::State& state) {
    run(state, [](const ErrorMeter& meter, const auto& image) { return meter.flip_ldr(image).mean; });
}
void flip_hdr(benchmark::State& state) {
    run(state, [](const ErrorMeter& meter, const auto& image) { return meter.flip_hdr(image).mean; });
}
void construct(benchmark::State& state) {
    run(state,
        [](const ErrorMeter& meter, const auto& image) { return ErrorMeter(meter.size(), image).reference_mean(); });
}

void sizes(benchmark::internal::Benchmark* benchmark) {
    benchmark->Args({256, 256})->Args({512, 512})->Args({1920, 1080})->Unit(benchmark::kMillisecond)->UseRealTime();
}
BENCHMARK(pointwise)->Apply(sizes);
BENCHMARK(percentiles)->Apply(sizes);
BENCHMARK(fireflies)->Apply(sizes);
BENCHMARK(construct)->Apply(sizes);
BENCHMARK(flip_ldr)->Apply(sizes);
BENCHMARK(flip_hdr)->Apply(sizes);

}  // namespace
}  // namespace photond

BENCHMARK_MAIN();
