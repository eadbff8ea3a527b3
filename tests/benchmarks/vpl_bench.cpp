// What making virtual lights takes on the CPU: milliseconds a pass, medians.

#include <cstdio>

#include "renderer/many_lights/vpl_tracer.h"
#include "renderer/scene/scene.h"
#include "tests/benchmarks/bench_scenes.h"

namespace photond {
namespace {

constexpr uint32_t kPasses = 15;

void measure(const NamedScene& named, const Scene& scene, const Intersector& intersector) {
    const EmissionSampler emission(scene);
    for (const VplTracing& tracing :
         {VplTracing{.vpls = 1024}, VplTracing{.vpls = 1024, .bounces = 3}, VplTracing{.vpls = 16'384, .bounces = 3},
          VplTracing{.vpls = 1024, .map_side = 512}}) {
        const VplTracer tracer(scene, intersector, intersector, emission, tracing);
        std::vector<double> rsm_ms, generation_ms;
        size_t lights = 0;
        for (uint32_t pass = 0; pass < kPasses; ++pass) {
            Stats stats;
            lights = tracer.trace(1, pass, {}, stats, CancelToken{}).photons.size();
            rsm_ms.push_back(1e3 * stats.stage("rsm").wall_seconds);
            generation_ms.push_back(1e3 * stats.stage("vpl_generation").wall_seconds);
        }
        std::printf("%-24s %6u paths, %u bounces, map %4u: rsm %7.2f ms, vpl_generation %7.2f ms, %6zu lights\n",
                    named.name, tracing.vpls, tracing.bounces, tracing.map_side, median(rsm_ms), median(generation_ms),
                    lights);
    }
}

}  // namespace
}  // namespace photond

int main() {
    using namespace photond;
    for (const NamedScene& named : kBenchScenes)
        if (const std::optional<Scene> scene = open(named)) measure(named, *scene, *build(*scene));
}
