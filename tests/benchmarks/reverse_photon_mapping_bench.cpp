// Reverse photon mapping against photon mapping's final gathering, of the same photons, rays and radius: how much
// sooner a pass is, for whole passes and for the search of photons alone, and whether the images agree. Prints a table;
// nothing passes or fails here.
//
// Measured on two cores of an AMD EPYC (AVX2) with much else running; 1,000,000 photons, 64 pixels wide, radius 0.03 of
// the scene's. How many times sooner than forward gathering (kd-tree with a fixed radius / hash grid):
//   gather rays      64          256         1024      lookups alone at 1024
//   cornell-box   2.0 / 1.7   3.1 / 2.4   4.3 / 3.8    8.8 / 7.8
//   sibenik       1.6 / 1.7   2.6 / 3.0   2.8 / 3.2    4.1 / 4.6
//   interior      1.4 / 1.5   1.9 / 1.5   2.0 / 1.8    3.3 / 2.9
// A pass cannot be sooner than its rays: without any photon a pass of 1024 rays takes 2.4 s of reverse mapping's 5.1 s
// in the Cornell box, 6.8 s of 22.4 s in Sibenik, 8.4 s of 19.1 s in the interior. With 200,000 photons lookups are
// less of it: 1.9 / 1.6, 1.9 / 1.8, 2.4 / 2.3 times sooner in the Cornell box, 1.2 / 1.1 and 1.3 / 1.1 in the interior.
//
// What was tried for lookups, by seconds of passes before and after, as far as so busy a machine lets tell. Photons
// near a group of points copied side by side, the grid's box search by compressing lanes, and no branch in the
// innermost loop: Cornell box 2.8, 1.7. Directions decoded once a pass for layered surfaces: interior's
// gathering 8.5, 6.1. Points with smooth normals in lanes of points: Sibenik 4.3, 3.2. Tiles of 2^16, 2^18, 2^20
// points: gathering 2.2, 1.6, 1.3 in the Cornell box, 12.3, 9.7, 8.7 in Sibenik (512 rays). Groups of 64 to 512 points
// and cells of 0.5 to 2 radii: no difference that can be told.
//
// Figures are processor seconds, so that what else runs on the machine shows less. "lookups" is what the stage `gather`
// takes beyond that of a pass whose maps are all but empty: tracing and shading gather rays are the same in all.
//
// Usage: reverse_photon_mapping_bench [PHOTONS] [WIDTH] [SCENE] [RAYS ...]; 1000000 photons, images 64 pixels wide, all
// scenes, and 64, 256 and 1024 rays without arguments.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/methods/reverse_photon_mapping/reverse_photon_mapping.h"
#include "tests/benchmarks/bench_scenes.h"
#include "tests/benchmarks/timed_render.h"

namespace photond {
namespace {

constexpr NamedScene kScenes[] = {
    {"cornell-box", nullptr, {64, 64}}, {"interior", nullptr, {64, 48}}, {"sibenik", "sibenik.glb", {64, 48}}};

struct Setting {
    uint32_t photons, rays;
    Size2 size;
};

/// Seconds of the processor, of all threads together.
double processor_seconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

void set(GatheringParams& params, const Setting& setting) {
    params.photons = setting.photons;
    params.gather_rays = setting.rays;
    params.boundary = DiscBoundary::None;
    params.radius_relative = 0.03f;
}

PhotonMappingParams forward(const Setting& setting, PhotonSearch::Kind search) {
    PhotonMappingParams params;
    set(params, setting);
    params.precompute_irradiance = false;
    params.search = search;
    // More than are ever near: the kd-tree finds all within the radius.
    if (search == PhotonSearch::Kind::Nearest) params.nearest_photons = 100'000;
    return params;
}

struct Measured {
    double pass_s, gather_s, wall_s;
    std::vector<float> indirect;
};

template <class M>
Measured measure(const Scene& scene, const Intersector& intersector, const Setting& setting,
                 const typename M::Params& params) {
    TimedRender<M> render(scene, intersector, setting.size, params);
    const double start = processor_seconds(), wall_start = render.seconds;
    render.pass();
    const double pass_s = processor_seconds() - start;
    return {pass_s, render.stats.stage("gather").cpu_seconds, render.seconds - wall_start,
            render.film.resolve(Layer::Indirect)};
}

/// The greatest difference of a value, over it or over the mean, which ever is more.
double most_difference(const std::vector<float>& a, const std::vector<float>& b) {
    double mean = 0, most = 0;
    for (const float value : b) mean += double(value) / double(b.size());
    for (size_t i = 0; i < a.size(); ++i)
        most = std::max(most, std::fabs(double(a[i]) - double(b[i])) / std::max(mean, double(b[i])));
    return most;
}

void compare(const char* name, const Scene& scene, const Intersector& intersector, const Setting& setting) {
    Setting empty = setting;
    empty.photons = 1;
    const auto gather_of = [&](PhotonSearch::Kind search) {
        return measure<PhotonMapping>(scene, intersector, setting, forward(setting, search));
    };
    const Measured rays =
        measure<PhotonMapping>(scene, intersector, setting, forward(empty, PhotonSearch::Kind::Radius));
    const Measured tree = gather_of(PhotonSearch::Kind::Nearest);
    ReversePhotonMappingParams params;
    params.influence_radius = InfluenceRadius::Fixed;
    set(params, setting);
    const Measured reverse = measure<ReversePhotonMapping>(scene, intersector, setting, params);
    const Measured grid = gather_of(PhotonSearch::Kind::Radius);
    const auto lookups = [&](const Measured& m) { return std::max(m.gather_s - rays.gather_s, 1e-9); };
    std::printf("%-12s %8u %5u  %7.2f %7.2f %7.2f %7.2f  %6.2f %6.2f   %6.2f %6.2f   %6.2f  %.1e\n", name,
                setting.photons, setting.rays, rays.pass_s, tree.pass_s, grid.pass_s, reverse.pass_s,
                tree.pass_s / reverse.pass_s, grid.pass_s / reverse.pass_s, lookups(tree) / lookups(reverse),
                lookups(grid) / lookups(reverse), tree.wall_s / reverse.wall_s,
                most_difference(reverse.indirect, grid.indirect));
    std::fflush(stdout);
}

}  // namespace
}  // namespace photond

int main(int argc, char** argv) {
    using namespace photond;
    const auto number = [&](int i, uint32_t otherwise) { return argc > i ? uint32_t(std::atoi(argv[i])) : otherwise; };
    const char* const only = argc > 3 ? argv[3] : "";
    std::vector<uint32_t> rays;
    for (int i = 4; i < argc; ++i) rays.push_back(number(i, 0));
    if (rays.empty()) rays = {64, 256, 1024};
    std::printf(
        "Processor seconds of a pass (without photons, kd-tree, hash grid, reverse); how many times sooner reverse is\n"
        "than tree and grid, as a pass and by lookups alone; than the tree by the wall; greatest difference of a "
        "value.\n"
        "scene         photons  rays    empty    tree    grid reverse    tree   grid     tree   grid     wall  most\n");
    for (const NamedScene& named : kScenes) {
        if (!std::strstr(named.name, only)) continue;
        const std::optional<Scene> scene = open(named);
        if (!scene) continue;
        const auto intersector = build(*scene);
        const uint32_t width = number(2, named.size.width);
        const Size2 size{width, width * named.size.height / named.size.width};
        for (const uint32_t count : rays)
            compare(named.name, *scene, *intersector, {number(1, 1'000'000), count, size});
    }
}
