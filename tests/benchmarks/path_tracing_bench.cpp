// Speed of path tracing: camera paths per CPU second, rays against bare ray tracing of the same rays, threads, and what
// low-discrepancy numbers save. Prints tables; nothing passes or fails here. Scenes beside the repository are optional.
//
// The rays' yardstick is the fastest of three ways to trace what pass 0 has asked for, batch by batch: through the
// renderer's intersector, and straight through Embree's C interface (bare_embree.h) as packets of eight and one by one.
// Measured on two cores (AMD Zen 4, AVX-512), in percent of that yardstick, three runs under some other load:
//   cornell_diffuse_dragon 61.0 61.0 61.3, sponza_crytek 61.7 61.1 61.7, interior 40, cornell-box 32 to 37 (where the
//   yardstick is our own SmallSceneIntersector, 2.4 times as fast as Embree).
//
// Usage: path_tracing_bench [paths] [replay] [threads] [samplers]; all of them without arguments.

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "renderer/error/error_meter.h"
#include "renderer/film/exr_file.h"
#include "renderer/methods/path_tracing/path_tracing.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/scene.h"
#include "tests/benchmarks/bare_embree.h"
#include "tests/benchmarks/bench_scenes.h"
#include "tests/benchmarks/recording_intersector.h"

namespace photond {
namespace {

/// A method begun on a scene, pass after pass into a film.
class Render {
public:
    Render(const Scene& scene, const Intersector& intersector, Size2 size, const PathTracingParams& params)
        : method_(params), film(size, LayerSet{}) {
        method_.begin({scene, &intersector, View{find_camera(scene, ""), size}, 1, budget_}, stats);
    }
    void pass() { pass(next_pass_++); }
    void pass(uint32_t index) {
        method_.run_pass(index, stats, CancelToken{});
        method_.resolve(film);
    }

private:
    MemoryBudget budget_;
    PathTracing method_;
    uint32_t next_pass_ = 0;

public:
    Stats stats;
    Film film;
};

void measure_paths() {
    std::printf("\nCamera paths per CPU second, film included (256x256 cornell-box, unlimited bounces, 1 thread)\n");
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Scene scene = make_builtin_scene("cornell-box");
    const auto intersector = build(scene);
    Render render(scene, *intersector, {256, 256}, {});
    render.pass();
    std::vector<double> seconds;
    for (int i = 0; i < 41; ++i) {
        const double start = cpu_now_seconds();
        render.pass();
        seconds.push_back(cpu_now_seconds() - start);
    }
    const Counts& counts = render.stats.counts;
    std::printf("  %.3f million (median of 41 passes; best %.3f); rays a path: %.2f bounce, %.2f shadow\n",
                65536e-6 / median(seconds), 65536e-6 / *std::min_element(seconds.begin(), seconds.end()),
                double(counts.bounce_rays) / double(counts.camera_rays),
                double(counts.shadow_rays) / double(counts.camera_rays));
    for (const Stage& stage : render.stats.stages)
        std::printf("  %-12s %5.1f ns a path\n", stage.name.c_str(), 1e9 * stage.cpu_seconds / (42 * 65536.0));
}

void measure_replay() {
    std::printf(
        "\nTime of path_tracing, film included, against only tracing the same rays (CPU ns a ray, medians)\n"
        "%-24s %8s %8s | %9s %9s %9s | best over path\n",
        "", "Mrays", "path", "renderer", "packets", "singles");
    for (const NamedScene& named : kBenchScenes) {
        const std::optional<Scene> scene = open(named);
        if (!scene) continue;
        const auto intersector = build(*scene);
        const RecordingIntersector recorder(*intersector);
        Render recorded(*scene, recorder, named.size, {});
        recorded.pass();  // pass 0 of the same run
        const BareEmbree bare(*scene, recorder.batches());
        bare.check(recorder.batches());
        size_t rays = 0;
        for (const RecordedBatch& batch : recorder.batches()) rays += batch.rays.size();

        enum { kPath, kRenderer, kPackets, kSingles, kWays };
        std::vector<double> ns[kWays];
        Render render(*scene, *intersector, named.size, {});
        for (int i = 0; i < 15; ++i) {  // alternately, so that other load on the machine meets all
            const auto measure = [&](int way, const auto& work) {
                const double start = cpu_now_seconds();
                work();
                ns[way].push_back(1e9 * (cpu_now_seconds() - start) / double(rays));
            };
            measure(kPath, [&] { render.pass(0); });
            measure(kRenderer, [&] { recorder.replay(); });
            measure(kPackets, [&] { bare.trace_packets(); });
            measure(kSingles, [&] { bare.trace_singles(); });
        }
        double cost[kWays];
        for (int way = 0; way < kWays; ++way) cost[way] = median(ns[way]);
        const double best = *std::min_element(cost + kRenderer, cost + kWays);
        std::printf("%-24s %8.3f %8.1f | %9.1f %9.1f %9.1f | %5.1f %%\n", named.name, 1e-6 * double(rays), cost[kPath],
                    cost[kRenderer], cost[kPackets], cost[kSingles], 100 * best / cost[kPath]);
    }
}

void measure_threads() {
    std::printf("\nThread scaling (wall seconds a pass, interior 320x240)\n");
    const Scene scene = make_builtin_scene("interior");
    const auto intersector = build(scene);
    double single = 0;
    const int cores = tbb::info::default_concurrency();
    for (int threads = 1;; threads = std::min(2 * threads, cores)) {
        // An arena of its own: the main thread's stays as wide as it was when first used.
        tbb::task_arena arena(threads);
        std::vector<double> seconds;
        arena.execute([&] {
            Render render(scene, *intersector, {320, 240}, {});
            render.pass();
            for (int i = 0; i < 7; ++i) {
                const double start = wall_now_seconds();
                render.pass();
                seconds.push_back(wall_now_seconds() - start);
            }
        });
        if (threads == 1) single = median(seconds);
        std::printf("  %3d threads %.4f s, %.2f times one\n", threads, median(seconds), single / median(seconds));
        if (threads == cores) break;
    }
}

void measure_samplers() {
    std::printf("\nrelative_mse x CPU seconds, random over sobol (cornell-box 64x64 against 65536 passes of sobol)\n");
    const Scene scene = make_builtin_scene("cornell-box");
    const auto intersector = build(scene);
    constexpr Size2 kSize{64, 64};
    PathTracingParams params;
    std::vector<float> reference;
    {
        Render render(scene, *intersector, kSize, params);
        for (int i = 0; i < 65536; ++i) render.pass();
        reference = render.film.resolve_beauty();
    }
    const ErrorMeter meter(kSize, std::move(reference));
    for (const uint32_t passes : {64u, 256u, 1024u}) {
        double cost[2];
        for (const SamplerKind kind : {SamplerKind::Sobol, SamplerKind::Random}) {
            params.sampler = kind;
            Render render(scene, *intersector, kSize, params);
            const double start = cpu_now_seconds();
            for (uint32_t i = 0; i < passes; ++i) render.pass();
            const double seconds = cpu_now_seconds() - start;
            const double error = meter.pointwise(render.film.resolve_beauty())[Metric::RelativeMse].value();
            cost[size_t(kind)] = error * seconds;
            std::printf("  %5u passes %-6s relative_mse %.3e, %.3f CPU s\n", passes,
                        kind == SamplerKind::Sobol ? "sobol" : "random", error, seconds);
        }
        std::printf("  %5u passes: random costs %.2f times sobol\n", passes, cost[1] / cost[0]);
    }
}

}  // namespace
}  // namespace photond

int main(int argc, char** argv) {
    using namespace photond;
    const std::pair<const char*, void (*)()> parts[] = {{"paths", measure_paths},
                                                        {"replay", measure_replay},
                                                        {"threads", measure_threads},
                                                        {"samplers", measure_samplers}};
    try {
        for (const auto& [name, measure] : parts)
            if (argc == 1 || std::any_of(argv + 1, argv + argc, [&](const char* a) { return !std::strcmp(a, name); }))
                measure();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "path_tracing_bench: %s\n", error.what());
        return 1;
    }
}
