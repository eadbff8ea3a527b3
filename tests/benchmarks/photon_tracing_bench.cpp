// Speed of photon tracing: a pass of global photons against bare ray tracing of the same rays, and threads. Prints
// tables; nothing passes or fails here. Scenes beside the repository are optional.
//
// The yardstick is Embree through its C interface (bare_embree.h), packets of eight or single rays, whichever is the
// faster, tracing what pass 0 has asked for, batch by batch.
//
// Measured on two quiet cores (Intel Xeon, AVX-512), share of Embree in photon tracing and nanoseconds a ray:
// cornell-box 98 % of 75 (Embree loses to the renderer's own structure there), interior 64.7 % of 304,
// cornell_diffuse_dragon 61.8 % of 165, sponza_crytek 59.1 % of 233 (1.13 rays a path, as the sun is outside). Two
// threads: 1.96 to 2.01 times one.
//
// Usage: photon_tracing_bench [replay] [threads]; both of them without arguments.

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "renderer/photons/photon_tracer.h"
#include "renderer/scene/scene.h"
#include "tests/benchmarks/bare_embree.h"
#include "tests/benchmarks/bench_scenes.h"
#include "tests/benchmarks/recording_intersector.h"

namespace photond {
namespace {

constexpr uint64_t kSeed = 1;

PhotonTracing settings() {
    PhotonTracing tracing;
    tracing.photons = 200'000;
    return tracing;
}

void measure_replay() {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    std::printf(
        "\nTime of a pass of 200,000 light paths against only tracing the same rays (CPU ns a ray, medians, 1 thread)\n"
        "%-24s %6s %6s %8s | %9s %9s %9s | %s\n",
        "", "Mrays", "Mphot.", "photons", "renderer", "packets", "singles", "Embree over photons");
    for (const NamedScene& named : kBenchScenes) {
        const std::optional<Scene> scene = open(named);
        if (!scene) continue;
        const auto intersector = build(*scene);
        const EmissionSampler emission(*scene);
        const RecordingIntersector recorder(*intersector);
        const TracedPhotons traced =
            PhotonTracer(*scene, recorder, emission, settings()).trace(kSeed, 0, CancelToken{});
        const BareEmbree bare(*scene, recorder.batches());
        bare.check(recorder.batches());
        const auto rays = double(traced.counts.photon_rays);

        enum { kPhotons, kRenderer, kPackets, kSingles, kWays };
        std::vector<double> ns[kWays];
        const PhotonTracer tracer(*scene, *intersector, emission, settings());
        for (int i = 0; i < 15; ++i) {  // alternately, so that other load on the machine meets all
            const auto measure = [&](int way, const auto& work) {
                const double start = cpu_now_seconds();
                work();
                ns[way].push_back(1e9 * (cpu_now_seconds() - start) / rays);
            };
            measure(kPhotons, [&] { (void)tracer.trace(kSeed, 0, CancelToken{}); });
            measure(kRenderer, [&] { recorder.replay(); });
            measure(kPackets, [&] { bare.trace_packets(); });
            measure(kSingles, [&] { bare.trace_singles(); });
        }
        double cost[kWays];
        for (int way = 0; way < kWays; ++way) cost[way] = median(ns[way]);
        std::printf("%-24s %6.3f %6.3f %8.1f | %9.1f %9.1f %9.1f | %5.1f %%\n", named.name, 1e-6 * rays,
                    1e-6 * double(traced.photons.size()), cost[kPhotons], cost[kRenderer], cost[kPackets],
                    cost[kSingles], 100 * std::min(cost[kPackets], cost[kSingles]) / cost[kPhotons]);
    }
}

void measure_threads() {
    std::printf("\nThread scaling (wall seconds a pass of 200,000 light paths)\n");
    for (const NamedScene& named : kBenchScenes) {
        const std::optional<Scene> scene = open(named);
        if (!scene) continue;
        const auto intersector = build(*scene);
        const EmissionSampler emission(*scene);
        const PhotonTracer tracer(*scene, *intersector, emission, settings());
        // Every number of threads in turn, so that other load on the machine meets all.
        const int cores = tbb::info::default_concurrency();
        std::vector<int> threads;
        for (int n = 1; n < cores; n *= 2) threads.push_back(n);
        threads.push_back(cores);
        std::vector<std::vector<double>> seconds(threads.size());
        for (int i = 0; i < 9; ++i)
            for (size_t k = 0; k < threads.size(); ++k) {
                tbb::task_arena arena(threads[k]);
                const double start = wall_now_seconds();
                arena.execute([&] { (void)tracer.trace(kSeed, 0, CancelToken{}); });
                seconds[k].push_back(wall_now_seconds() - start);
            }
        std::printf("%-24s", named.name);
        for (size_t k = 0; k < threads.size(); ++k)
            std::printf(" | %3d threads %.4f s, %.2f times one", threads[k], median(seconds[k]),
                        median(seconds[0]) / median(seconds[k]));
        std::printf("\n");
    }
}

}  // namespace
}  // namespace photond

int main(int argc, char** argv) {
    using namespace photond;
    const std::pair<const char*, void (*)()> parts[] = {{"replay", measure_replay}, {"threads", measure_threads}};
    try {
        for (const auto& [name, measure] : parts)
            if (argc == 1 || std::any_of(argv + 1, argv + argc, [&](const char* a) { return !std::strcmp(a, name); }))
                measure();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "photon_tracing_bench: %s\n", error.what());
        return 1;
    }
}
