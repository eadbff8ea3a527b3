// The techniques of bidirectional path tracing and of merging: what a pass with some of them costs by the clock, beside
// what the pilot counts (technique_choice.h), and the relative variance that it expects. Both as times of the eye's
// paths alone. Prints tables; nothing passes or fails here. The seconds are CPU seconds of whole passes, the least of
// several.
//
// Usage: bidirectional_bench [SCENE ...]; built-in scenes, by default a box, a room and SmallVCM's box.

#include <cstdio>
#include <string>
#include <vector>

#include "renderer/bidirectional/light_paths.h"
#include "renderer/bidirectional/technique_pilot.h"
#include "renderer/methods/vertex_connection_and_merging/vertex_connection_and_merging.h"
#include "tests/benchmarks/bench_scenes.h"
#include "tests/benchmarks/timed_render.h"

namespace photond {
namespace {

constexpr Size2 kSize{128, 128};
constexpr uint32_t kPasses = 6;
constexpr float kMergeRadius = 0.015f;  // of the scene's: about a dozen vertices in a pass

double seconds_of(const Scene& scene, const Intersector& intersector, const TechniqueCandidate& candidate) {
    VertexConnectionAndMergingParams params;
    params.adapt = false;
    params.light_paths = candidate.light_paths;
    params.connections_per_vertex = candidate.connections;
    params.merging_params.radius_relative = kMergeRadius;
    if (!candidate.merges) params.merging_params.radius_relative = 1e-9f;  // within which nothing is
    TimedRender<VertexConnectionAndMerging> render(scene, intersector, kSize, params);
    double least = 1e30;
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
        const double before = cpu_now_seconds();
        render.pass();
        least = std::min(least, cpu_now_seconds() - before);
    }
    return least;
}

void show(const char* name) {
    const Scene scene = make_builtin_scene(name);
    const auto intersector = build(scene);
    VertexConnectionAndMergingParams params;
    MemoryBudget budget;
    const RenderContext context{scene, intersector.get(), View{find_camera(scene, ""), kSize}, 1, budget};
    const BidirectionalScene shared(context, params);
    LightPathTracer tracer(shared);
    Counts counts;
    PassTechniques light;
    light.light_paths = static_cast<uint32_t>(kSize.pixels());
    const double vertices = static_cast<double>(tracer.trace(1, 0, light, counts, CancelToken{}).vertices.size()) /
                            static_cast<double>(kSize.pixels());
    Stats stats;
    const DiscCoverage coverage(scene, *intersector, kMergeRadius * scene.bounds.radius());
    const TechniquePilot pilot = run_technique_pilot({context,
                                                      params,
                                                      vertices,
                                                      {.most_light_paths = 2, .merges = true},
                                                      kMergeRadius * scene.bounds.radius(),
                                                      nullptr,
                                                      &coverage},
                                                     stats);
    std::printf("%s, %u x %u: %.1f vertices of a light path\n", name, kSize.width, kSize.height, vertices);
    std::printf("  light paths  connections  merges      clock    counted   variance  worth\n");
    double alone_s = 0;
    const JudgedCandidate& alone = pilot.candidates.front();
    for (size_t i = 0; i < pilot.candidates.size(); ++i) {
        const JudgedCandidate& c = pilot.candidates[i];
        if (c.candidate.connections == 2 || c.candidate.connections == 8 || c.candidate.light_paths == 0.75f) continue;
        const double seconds = seconds_of(scene, *intersector, c.candidate);
        if (i == 0) alone_s = seconds;
        std::printf("  %11.2f  %11u  %6s  %9.2f  %9.2f  %9.3f  %.3f%s\n", double{c.candidate.light_paths},
                    c.candidate.connections, c.candidate.merges ? "yes" : "no", seconds / alone_s, c.cost / alone.cost,
                    c.relative_variance / alone.relative_variance,
                    c.relative_variance * c.cost / (alone.relative_variance * alone.cost),
                    i == pilot.chosen.everywhere ? "  chosen" : "");
    }
}

}  // namespace
}  // namespace photond

int main(int argc, char** argv) {
    if (argc > 1)
        for (int i = 1; i < argc; ++i) photond::show(argv[i]);
    else
        for (const char* name : {"cornell-box", "interior", "small-vcm/ceiling"}) photond::show(name);
}
