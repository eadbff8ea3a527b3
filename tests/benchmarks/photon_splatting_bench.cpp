// Photon splatting: what splats cost. Prints tables; nothing passes or fails here.
//
//   exponents   how the seconds of finding and adding splats grow with their number, and with the points they cover
//   rate        contributions of a splat to a visible point, a second and core, without visibility and with it
//
// The seconds are CPU seconds of the stages splat_find and splat, the least of several passes.
//
// Usage: photon_splatting_bench [exponents] [rate]; both without arguments.

#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/scene/scene.h"
#include "tests/benchmarks/bench_scenes.h"
#include "tests/benchmarks/timed_render.h"
#include "tests/support/threads.h"

namespace photond {
namespace {

constexpr uint32_t kPasses = 5;

struct Cost {
    double seconds = 0;  // of one pass
    double splats = 0, contributions = 0;
};

double stage_seconds(Stats& stats) { return stats.stage("splat_find").cpu_seconds + stats.stage("splat").cpu_seconds; }

/// A built-in scene with its rays.
struct BenchScene {
    explicit BenchScene(const char* scene_name)
        : name(scene_name), scene(make_builtin_scene(scene_name)), intersector(build(scene)) {}
    std::string name;
    Scene scene;
    std::unique_ptr<Intersector> intersector;
};

Cost cost_of(const BenchScene& scene, Size2 size, const PhotonSplattingParams& params) {
    TimedRender<PhotonSplatting> render(scene.scene, *scene.intersector, size, params);
    Cost cost{.seconds = 1e30};
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
        const double before = stage_seconds(render.stats);
        render.pass();
        cost.seconds = std::min(cost.seconds, stage_seconds(render.stats) - before);
    }
    cost.splats = double(render.stats.counts.splats) / kPasses;
    cost.contributions = double(render.stats.counts.splat_contributions) / kPasses;
    return cost;
}

void print(const char* what, const Cost& cost, const Cost* before) {
    std::printf("  %-24s %9.0f splats %12.0f contributions %9.2f ms", what, cost.splats, cost.contributions,
                1e3 * cost.seconds);
    if (before) {
        const double time = std::log(cost.seconds / before->seconds);
        std::printf("   exponent in splats %5.2f, in contributions %5.2f",
                    time / std::log(cost.splats / before->splats),
                    time / std::log(cost.contributions / before->contributions));
    }
    std::printf("\n");
}

PhotonSplattingParams plain_params() {
    PhotonSplattingParams params;
    params.adaptive_size = false;  // sizes as they are said
    return params;
}

void exponents(const BenchScene& scene) {
    std::printf("%s: more splats of the same size (512x512, 1 m)\n", scene.name.c_str());
    std::vector<Cost> costs;
    for (const uint32_t photons : {1000u, 4000u, 16'000u, 64'000u}) {
        PhotonSplattingParams params = plain_params();
        params.splat_size_m = 1.0f;
        params.photons = photons;
        costs.push_back(cost_of(scene, {512, 512}, params));
        print(std::to_string(photons).c_str(), costs.back(), costs.size() > 1 ? &costs[costs.size() - 2] : nullptr);
    }
    std::printf("%s: larger splats (512x512, 4,000 photons)\n", scene.name.c_str());
    costs.clear();
    for (const float side_m : {0.25f, 0.5f, 1.0f, 2.0f}) {
        PhotonSplattingParams params = plain_params();
        params.splat_size_m = side_m;
        params.photons = 4000;
        costs.push_back(cost_of(scene, {512, 512}, params));
        print((std::to_string(side_m) + " m").c_str(), costs.back(),
              costs.size() > 1 ? &costs[costs.size() - 2] : nullptr);
    }
    std::printf("%s: the same number of points a splat in larger images (4,000 photons)\n", scene.name.c_str());
    for (const uint32_t side : {256u, 512u, 1024u}) {
        PhotonSplattingParams params = plain_params();
        params.splat_size_m = 2.0f * 256.0f / static_cast<float>(side);
        params.photons = 4000;
        print((std::to_string(side) + " pixels").c_str(), cost_of(scene, {side, side}, params), nullptr);
    }
}

void rate(const BenchScene& scene) {
    std::printf("%s: contributions on one core (512x512, 10,000 photons, 2 m)\n", scene.name.c_str());
    for (const bool visibility : {false, true}) {
        PhotonSplattingParams params = plain_params();
        params.splat_size_m = 2.0f;
        params.visibility = visibility;
        TimedRender<PhotonSplatting> render(scene.scene, *scene.intersector, {512, 512}, params);
        double adding = 1e30, finding = 1e30;
        for (uint32_t pass = 0; pass < kPasses; ++pass) {
            const double added = render.stats.stage("splat").cpu_seconds;
            const double found = render.stats.stage("splat_find").cpu_seconds;
            render.pass();
            adding = std::min(adding, render.stats.stage("splat").cpu_seconds - added);
            finding = std::min(finding, render.stats.stage("splat_find").cpu_seconds - found);
        }
        const double contributions = double(render.stats.counts.splat_contributions) / kPasses;
        std::printf(
            "  visibility %-3s  adding %7.1f million/s, finding and adding %7.1f million/s, shadow rays %.3f each\n",
            visibility ? "on" : "off", 1e-6 * contributions / adding, 1e-6 * contributions / (adding + finding),
            double(render.stats.counts.shadow_rays) / kPasses / contributions);
    }
}

}  // namespace
}  // namespace photond

int main(int argc, char** argv) {
    using namespace photond;
    const auto asked = [&](const char* what) {
        for (int i = 1; i < argc; ++i)
            if (std::strcmp(argv[i], what) == 0) return true;
        return argc == 1;
    };
    for (const char* name : {"cornell-box-spot", "interior"}) {
        const BenchScene scene(name);
        if (asked("exponents")) exponents(scene);
        if (asked("rate")) test::on_threads(1, [&] { rate(scene); });
    }
    return 0;
}
