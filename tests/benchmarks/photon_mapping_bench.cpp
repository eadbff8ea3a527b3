// Photon mapping as a whole: seconds by stage, error over time beside path tracing, and the table of [Jensen 1996]
// redone on our scenes. Prints tables; nothing passes or fails here.
//
// Measured on two quiet cores (Intel Xeon, AVX-512). Wall seconds a pass of 512x512 with 200,000 photons, 50 nearest:
// direct 0.19, final (64 rays) 7.1, with clipped discs 8.6, with irradiance precomputed as well 2.8. relative_mse of
// the indirect layer after about 22 s (its reference's own noise is 1.6e-3 of these):
//   path_tracing 3.7e-3, direct 1.1e-2 (its bias), direct with clip 3.7e-3, final 4.8e-3, final with clip and
//   precomputed irradiance 1.8e-3, final with clip and 8 rays 2.8e-3.
// Within the first second: path_tracing 1.2e-1, direct with clip 1.0e-2.
// [Jensen 1996]'s two rows: pass 1 0.13 s and 2.1 s (his 67 s and 298 s), rendering with 16 gather rays 9.1 s and 38 s.
// Clipped discs against whole ones, renders of 3 passes of 160x120 with what is built beforehand, on one core of an AMD
// EPYC (clip : none): interior direct 1.7, final (irradiance precomputed) 1.8; a heap of chips with 36,000 edges within
// the search radius direct 1.7, final 1.5.
//
// Usage: photon_mapping_bench [stages] [error] [jensen] [clip]; all of them without arguments.
//
// [Jensen 1996] Global Illumination using Photon Maps. Eurographics Workshop on Rendering, Table 1.

#include <cmath>
#include <cstring>

#include "protocol/error.h"
#include "renderer/core/rng.h"
#include "renderer/error/error_meter.h"
#include "renderer/methods/path_tracing/path_tracing.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/photons/disc_coverage.h"
#include "renderer/scene/mesh_builder.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/sampling.h"
#include "tests/benchmarks/bench_scenes.h"
#include "tests/benchmarks/timed_render.h"

namespace photond {
namespace {

struct Setting {
    const char* name;
    PhotonMappingParams params;
};

/// 200,000 photons and the 50 nearest, as is the default; the fifth is the default.
std::vector<Setting> settings() {
    std::vector<Setting> list(6);
    list[0].name = "direct";
    list[1].name = "direct, clip";
    list[2].name = "final";
    list[3].name = "final, clip";
    list[4].name = "final, clip, irradiance";
    list[5].name = "final, clip, 8 rays";
    for (const size_t direct : {0, 1}) list[direct].params.gather = Gather::Direct;
    for (const size_t whole : {0, 2}) list[whole].params.boundary = DiscBoundary::None;
    for (const size_t at_ends : {2, 3, 5}) list[at_ends].params.precompute_irradiance = false;
    list[5].params.gather_rays = 8;
    return list;
}

void print_stages(const Stats& stats, uint32_t passes) {
    for (const Stage& stage : stats.stages)
        std::printf("    %-20s %8.4f wall %8.4f CPU s a pass\n", stage.name.c_str(), stage.wall_seconds / passes,
                    stage.cpu_seconds / passes);
}

void measure_stages() {
    std::printf("\nSeconds by stage: cornell-box 512x512, 200,000 photons, 50 nearest, mean of 3 passes\n");
    const Scene scene = make_builtin_scene("cornell-box");
    const auto intersector = build(scene);
    for (const Setting& setting : settings()) {
        TimedRender<PhotonMapping> render(scene, *intersector, {512, 512}, setting.params);
        for (int i = 0; i < 3; ++i) render.pass();
        std::printf("  %s: %.3f s a pass, %.1f MB\n", setting.name, render.seconds / 3,
                    1e-6 * double(render.budget.accounted_bytes()));
        print_stages(render.stats, 3);
    }
}

/// Error of the indirect layer at passes 1, 2, 4 ... until `seconds` are over.
double relative_mse(const ErrorMeter& meter, const std::vector<float>& image) {
    return meter.pointwise(image)[Metric::RelativeMse].value();
}

template <class M>
void error_over_time(const char* name, TimedRender<M>&& render, const ErrorMeter& meter, double seconds) {
    std::printf("  %-26s", name);
    for (uint32_t next = 1; render.seconds < seconds; next *= 2) {
        while (render.film.passes() < next) render.pass();
        std::printf("  %.2f s %.2e", render.seconds, relative_mse(meter, render.film.resolve(Layer::Indirect)));
        std::fflush(stdout);
    }
    std::printf("\n");
}

void measure_error() {
    constexpr Size2 kSize{512, 512};
    constexpr uint32_t kReferencePasses = 2048;
    constexpr double kSeconds = 20;
    const Scene scene = make_builtin_scene("cornell-box");
    const auto intersector = build(scene);
    TimedRender<PathTracing> truth(scene, *intersector, kSize, {}, 2);
    while (truth.film.passes() < kReferencePasses) truth.pass();
    const std::vector<float> reference = truth.film.resolve(Layer::Indirect);
    const std::vector<float> variance = truth.film.pass_variance(Layer::Indirect);
    const ErrorMeter meter(kSize, reference);
    std::vector<float> noisy = reference;
    for (size_t i = 0; i < noisy.size(); ++i) noisy[i] += std::sqrt(variance[i] / kReferencePasses);
    std::printf(
        "\nrelative_mse of the indirect layer over wall seconds (cornell-box 512x512, all bounces; reference: %u\n"
        "passes of path_tracing, %.0f s, its own noise %.1e)\n",
        kReferencePasses, truth.seconds, relative_mse(meter, noisy));
    error_over_time("path_tracing", TimedRender<PathTracing>(scene, *intersector, kSize, {}), meter, kSeconds);
    for (const Setting& setting : settings())
        error_over_time(setting.name, TimedRender<PhotonMapping>(scene, *intersector, kSize, setting.params), meter,
                        kSeconds);
}

/// One row: our scene with as many photons stored as Jensen had.
struct JensenRow {
    const char* scene;
    const char* his_scene;
    double caustic, global;  // photons stored
    double his_pass1_s, his_rendering_s;
};
constexpr JensenRow kJensen[] = {{"cornell-box-glass", "Diffuse Cornell Box", 21'162, 286'489, 67, 8 * 60},
                                 {"interior", "The Museum", 389'755, 165'791, 298, 51 * 60}};

void measure_jensen() {
    constexpr Size2 kSize{1280, 960};
    std::printf("\n[Jensen 1996, Table 1] redone at 1280x960: photons stored as in his table, one eye path a pixel\n");
    for (const JensenRow& row : kJensen) {
        const Scene scene = make_builtin_scene(row.scene);
        const auto intersector = build(scene);
        PhotonMappingParams params;
        params.gather_rays = 16;
        // How many of the paths leave a photon in which map, by one small pass of each alone.
        const auto stored = [&](uint32_t photons, uint32_t caustic_photons) {
            PhotonMappingParams probe = params;
            probe.gather = Gather::Direct;
            probe.photons = photons, probe.caustic_photons = caustic_photons;
            TimedRender<PhotonMapping> render(scene, *intersector, {4, 4}, probe);
            render.pass();
            return double(render.stats.counts.photons_stored);
        };
        constexpr uint32_t kProbe = 100'000;
        const double global_yield = stored(kProbe, 1) / kProbe, caustic_yield = stored(1, kProbe) / kProbe;
        params.photons = uint32_t(row.global / global_yield);
        params.caustic_photons = uint32_t(row.caustic / caustic_yield);

        for (const Gather gather : {Gather::Direct, Gather::Final}) {
            params.gather = gather;
            TimedRender<PhotonMapping> render(scene, *intersector, kSize, params);
            render.pass();
            double pass1 = 0, rendering = 0;
            for (const Stage& stage : render.stats.stages) {
                const bool first = stage.name.starts_with("photon_");
                (first ? pass1 : rendering) += stage.wall_seconds;
            }
            const std::string how =
                gather == Gather::Direct ? "direct" : "final, " + std::to_string(*params.gather_rays) + " rays";
            std::printf(
                "  %-18s %-15s %8llu photons stored of %u + %u paths; pass 1 %.2f s, rendering %.2f s\n"
                "      (%s: %.0f + %.0f photons; pass 1 %.0f s, rendering %.0f min on his machine of 1996)\n",
                row.scene, how.c_str(), static_cast<unsigned long long>(render.stats.counts.photons_stored),
                params.photons, *params.caustic_photons, pass1, rendering, row.his_scene, row.caustic, row.global,
                row.his_pass1_s, row.his_rendering_s / 60);
        }
    }
}

/// A room of 4 x 3 x 4 m with a heap of chips, 12 x 12 x 2 mm each, on its floor: some 36,000 half-edges within one
/// search radius (16 cm).
Scene make_heap_of_chips() {
    constexpr int kChips = 1500;
    constexpr float kHeapRadius = 0.14f, kHeapHeight = 0.08f;
    MeshBuilder room, heap, lamp;
    room.quad({-2, 0, 2}, {2, 0, 2}, {2, 0, -2}, {-2, 0, -2});
    room.quad({-2, 3, -2}, {2, 3, -2}, {2, 3, 2}, {-2, 3, 2});
    room.quad({-2, 0, -2}, {2, 0, -2}, {2, 3, -2}, {-2, 3, -2});
    room.quad({-2, 0, 2}, {-2, 0, -2}, {-2, 3, -2}, {-2, 3, 2});
    room.quad({2, 0, -2}, {2, 0, 2}, {2, 3, 2}, {2, 3, -2});
    lamp.quad({-0.5f, 2.99f, -0.5f}, {0.5f, 2.99f, -0.5f}, {0.5f, 2.99f, 0.5f}, {-0.5f, 2.99f, 0.5f});
    RandomStream random(1, RandomDomain::Test, 0, 0);
    for (int i = 0; i < kChips; ++i) {
        const vec2 at = random.next_2d();
        const float reach = std::sqrt(at.x), height = 0.005f + kHeapHeight * (1 - reach) * random.next();
        const vec3 centre(kHeapRadius * reach * std::cos(2 * kPi * at.y), height,
                          kHeapRadius * reach * std::sin(2 * kPi * at.y));
        const vec3 axis(random.next() - 0.5f, 2 * random.next(), random.next() - 0.5f);
        heap.place(glm::rotate(glm::translate(mat4(1), centre), 2 * kPi * random.next(), glm::normalize(axis)));
        heap.box({-0.006f, -0.001f, -0.006f}, {0.006f, 0.001f, 0.006f});
    }
    Scene scene;
    const auto add = [&](const Mesh& mesh) {
        Instance instance;
        instance.mesh = static_cast<uint32_t>(scene.meshes.size());
        scene.meshes.push_back(mesh);
        scene.instances.push_back(instance);
    };
    scene.materials.resize(3);
    for (Material& material : scene.materials) material.metallic = 0, material.specular = 0;
    scene.materials[0].base_color = Rgb(0.7f), scene.materials[1].base_color = Rgb(0.7f, 0.4f, 0.2f);
    scene.materials[2].emission = Rgb(12);
    add(room.build(0)), add(heap.build(1)), add(lamp.build(2));
    scene.cameras.push_back(look_at_camera({0, 0.45, 0.6}, {0, 0.03, 0}, {0, 1, 0}, 0.7f));
    finish_scene(scene);
    return scene;
}

/// What clipped discs cost: seconds of whole renders, what is built beforehand included, with boundary "none" and
/// "clip" in turn.
void measure_clip() {
    constexpr int kRepeats = 3, kPasses = 3;
    std::printf("\nboundary clip against none: medians of %d renders of %d passes at 160x120, wall seconds\n", kRepeats,
                kPasses);
    for (const char* name : {"heap of chips", "interior"}) {
        const Scene scene = name == std::string("interior") ? make_builtin_scene(name) : make_heap_of_chips();
        const auto intersector = build(scene);
        const double start = wall_now_seconds();
        const DiscCoverage coverage(scene, *intersector, PhotonMappingParams().search_radius_m(scene.bounds.radius()));
        std::printf("  %s: built in %.3f s, %.1f MB\n", name, wall_now_seconds() - start,
                    1e-6 * double(coverage.bytes()));
        for (const Gather gather : {Gather::Direct, Gather::Final}) {
            std::vector<double> none, clip, ratios;
            for (int i = 0; i < kRepeats; ++i) {
                const auto seconds = [&](DiscBoundary discs) {
                    PhotonMappingParams params;
                    params.gather = gather;
                    params.boundary = discs;
                    TimedRender<PhotonMapping> render(scene, *intersector, {160, 120}, params);
                    for (int pass = 0; pass < kPasses; ++pass) render.pass();
                    return render.seconds;
                };
                none.push_back(seconds(DiscBoundary::None)), clip.push_back(seconds(DiscBoundary::Clip));
                ratios.push_back(clip.back() / none.back());
            }
            const auto [least, most] = std::minmax_element(ratios.begin(), ratios.end());
            std::printf("    %-6s none %.2f s, clip %.2f s, ratio %.2f (%.2f to %.2f)\n",
                        gather == Gather::Direct ? "direct" : "final", median(none), median(clip),
                        median(clip) / median(none), *least, *most);
            std::fflush(stdout);
        }
    }
}

}  // namespace
}  // namespace photond

int main(int argc, char** argv) {
    using namespace photond;
    const std::pair<const char*, void (*)()> parts[] = {
        {"stages", measure_stages}, {"error", measure_error}, {"jensen", measure_jensen}, {"clip", measure_clip}};
    try {
        for (const auto& [name, measure] : parts)
            if (argc == 1 || std::any_of(argv + 1, argv + argc, [&](const char* a) { return !std::strcmp(a, name); }))
                measure();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "photon_mapping_bench: %s\n", error.what());
        return 1;
    }
}
