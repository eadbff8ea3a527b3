// The voxel octree: building it, marching through it against Embree's shadow rays, and what its answers are worth.
//
//     svo_bench [Google Benchmark's options]
//     svo_bench errors [resolution ...]     false shadows and leaks by how far segments' ends are moved; default 128
//     256

#include <benchmark/benchmark.h>

#include <cstring>

#include "renderer/core/parallel.h"
#include "renderer/core/rng.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/sampling.h"
#include "renderer/transport/surface.h"
#include "renderer/voxels/sparse_voxel_octree.h"
#include "renderer/voxels/sparse_voxel_octree_gpu.h"
#include "tests/benchmarks/bench_scenes.h"
#include "tests/support/gpu_twin.h"

namespace photond {
namespace {

constexpr NamedScene kScenes[] = {{"cornell-box", nullptr, {256, 256}},
                                  {"interior", nullptr, {320, 240}},
                                  {"cornell_dragon_buddha", "cornell_dragon_buddha.glb", {256, 256}},
                                  {"sponza_crytek", "sponza_crytek.glb", {320, 180}}};

struct Segment {
    vec3 a, normal_a, b, normal_b;
    float geometry;  // G of the many-lights' sum: what the segment may carry
    bool blocked;    // says Embree
};

struct Point {
    vec3 position, normal;
};

Point point_of(const Scene& scene, const Hit& hit, const vec3& direction) {
    const ShadingPoint at = make_shading_point(scene, hit, direction);
    return {at.position, at.geometric_normal};
}

/// From what the camera sees to what a Lambert bounce from elsewhere meets, as virtual point lights are spread.
std::vector<Segment> make_segments(const Scene& scene, Size2 size, const Intersector& rays, float bound_m2) {
    const Camera camera = find_camera(scene, "");
    RandomStream random(1, RandomDomain::Test, 0, 0);
    std::vector<Point> seen, lights;
    for (uint32_t i = 0; i < size.pixels(); ++i) {
        const vec2 pixel(float(i % size.width), float(i / size.width));
        const Ray ray = camera_ray(camera, size, pixel + random.next_2d(), vec2(0.5f));
        const Hit hit = rays.closest_hit(ray);
        if (!hit.valid()) continue;
        const Point point = point_of(scene, hit, ray.direction);
        seen.push_back(point);
        const vec3 w = Frame(point.normal).to_world(sample_cosine_hemisphere(random.next_2d()));
        const Ray bounce{offset_ray_origin(point.position, point.normal), w};
        if (const Hit next = rays.closest_hit(bounce); next.valid()) lights.push_back(point_of(scene, next, w));
    }
    std::vector<Segment> segments;
    for (const Point& a : seen) {
        for (int k = 0; k < 4; ++k) {
            const Point& b = lights[random.next_bits() % lights.size()];
            const vec3 d = b.position - a.position;
            const float cos_a = glm::dot(a.normal, d), cos_b = -glm::dot(b.normal, d), d_sq = glm::dot(d, d);
            if (!(cos_a > 0) || !(cos_b > 0)) continue;
            const vec3 from = offset_ray_origin(a.position, a.normal), to = offset_ray_origin(b.position, b.normal);
            segments.push_back({a.position, a.normal, b.position, b.normal,
                                cos_a * cos_b / d_sq / std::max(d_sq, bound_m2), rays.occluded({from, to - from, 1})});
        }
    }
    return segments;
}

struct Errors {
    double false_shadows, leaks;  // shares of what Embree lets through, in G
    double changed;               // of segments
};

template <class Occluded>
Errors errors_of(const std::vector<Segment>& segments, const Occluded& occluded) {
    double all = 0, shadow = 0, leak = 0, changed = 0;
    for (const Segment& s : segments) {
        const bool blocked = occluded(s);
        all += s.blocked ? 0 : double{s.geometry};
        shadow += blocked && !s.blocked ? double{s.geometry} : 0;
        leak += !blocked && s.blocked ? double{s.geometry} : 0;
        changed += blocked != s.blocked;
    }
    return {shadow / all, leak / all, changed / double(segments.size())};
}

void print_errors(const std::vector<uint32_t>& resolutions) {
    for (const NamedScene& named : kScenes) {
        const std::optional<Scene> scene = open(named);
        if (!scene) continue;
        const std::unique_ptr<Intersector> rays = build(*scene);
        const float bound_m2 = sqr(0.05f * scene->bounds.radius());
        const std::vector<Segment> segments = make_segments(*scene, named.size, *rays, bound_m2);
        for (const uint32_t resolution : resolutions) {
            const SparseVoxelOctree tree(*scene, make_voxel_grid(scene->bounds, resolution), false);
            std::printf("%s, %u^3, %zu segments: false shadows - leaks [%% of the unshadowed G]\n%8s", named.name,
                        resolution, segments.size(), "lift");
            const float pulls[] = {0, 0.5f, 1, 1.5f, 2, 3};
            for (const float pull : pulls) std::printf("   pull in %.1f", double{pull});
            std::printf("\n");
            for (const float lift : {0.0f, 0.5f, 0.75f, 1.0f, 1.25f, 1.5f, 2.0f}) {
                std::printf("%8.2f", double{lift});
                for (const float pull : pulls) {
                    const Errors errors = errors_of(segments, [&](const Segment& s) {
                        return svo_occluded(tree.view(), s.a, s.normal_a, s.b, s.normal_b, {lift, pull});
                    });
                    std::printf("  %5.2f -%5.2f", 100 * errors.false_shadows, 100 * errors.leaks);
                }
                std::printf("\n");
            }
            const Errors blind =
                errors_of(segments, [&](const Segment& s) { return svo_occluded(tree.view(), s.a, s.b); });
            std::printf("without normals %5.2f -%5.2f\n", 100 * blind.false_shadows, 100 * blind.leaks);
        }
    }
}

void build_cpu(benchmark::State& state, const Scene& scene, uint32_t resolution) {
    const VoxelGrid grid = make_voxel_grid(scene.bounds, resolution);
    for (auto _ : state) {
        const SparseVoxelOctree tree(scene, grid, true);
        state.counters["MB"] = 1e-6 * double(tree.bytes());
        state.counters["voxels"] = double(tree.voxel_count());
        state.counters["bytes/voxel"] = double(tree.bytes()) / double(tree.voxel_count());
    }
}

void build_gpu(benchmark::State& state, const Scene& scene, uint32_t resolution) {
    gpu::Device& device = test::gpu_device();
    const gpu::DeviceScene device_scene(device, scene);
    SparseVoxelOctreeGpu tree(device_scene, make_voxel_grid(scene.bounds, resolution), true);
    Stats stats;
    tree.build_now(stats);
    Stats timed;
    for (auto _ : state) {
        gpu::CommandList commands(device);
        tree.record_build(commands);
        commands.submit();
        commands.wait();
        commands.add_times(timed);
    }
    const double runs = double(state.iterations());
    state.counters["voxelise_ms"] = 1e3 * timed.stage("voxelise").gpu_seconds / runs;
    state.counters["svo_build_ms"] = 1e3 * timed.stage("svo_build").gpu_seconds / runs;
    state.counters["fragments"] = double(tree.fragment_count());
    state.counters["MB"] = 1e-6 * double(tree.device_bytes());
    state.counters["scratch_MB"] = 1e-6 * double(tree.device_bytes_with_scratch() - tree.device_bytes());
}

/// All segments by as many threads as there are.
template <class Occluded>
void march(benchmark::State& state, const std::vector<Segment>& segments, const Occluded& occluded) {
    for (auto _ : state) {
        parallel_for((segments.size() + 1023) / 1024, 1, [&](size_t part) {
            bool any = false;
            for (size_t i = part * 1024; i < std::min((part + 1) * 1024, segments.size()); ++i)
                any |= occluded(segments[i]);
            benchmark::DoNotOptimize(any);
        });
    }
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(segments.size()));
}

void march_in_lanes(benchmark::State& state, const std::vector<Segment>& segments, const SvoView& tree) {
    constexpr size_t kAtOnce = 24;
    std::vector<SvoSegment> asked;
    for (const Segment& s : segments) asked.push_back({s.a, s.normal_a, s.b, s.normal_b});
    std::vector<uint8_t> occluded(asked.size());
    for (auto _ : state) {
        parallel_for((asked.size() + kAtOnce - 1) / kAtOnce, 32, [&](size_t part) {
            const size_t first = part * kAtOnce, count = std::min(kAtOnce, asked.size() - first);
            svo_occluded(tree, std::span(asked).subspan(first, count), std::span(occluded).subspan(first, count));
        });
        benchmark::DoNotOptimize(occluded.data());
    }
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(segments.size()));
}

void register_scene(const NamedScene& named) {
    const auto scene = std::make_shared<std::optional<Scene>>(open(named));
    if (!*scene) return;
    const auto rays = std::shared_ptr<Intersector>(build(**scene));
    const auto segments = std::make_shared<std::vector<Segment>>(make_segments(**scene, named.size, *rays, 1e-9f));
    const std::string name = named.name;
    benchmark::RegisterBenchmark((name + "/embree_shadow_rays").c_str(), [=](benchmark::State& state) {
        march(state, *segments, [&](const Segment& s) {
            const vec3 from = offset_ray_origin(s.a, s.normal_a), to = offset_ray_origin(s.b, s.normal_b);
            return rays->occluded({from, to - from, 1});
        });
        benchmark::DoNotOptimize(scene->has_value());
    })->UseRealTime();
    for (const uint32_t resolution : {128u, 256u, 512u}) {
        const std::string at = "/" + std::to_string(resolution);
        benchmark::RegisterBenchmark((name + "/build_cpu" + at).c_str(),
                                     [=](benchmark::State& state) { build_cpu(state, **scene, resolution); })
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
        benchmark::RegisterBenchmark((name + "/build_gpu" + at).c_str(),
                                     [=](benchmark::State& state) { build_gpu(state, **scene, resolution); })
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
        benchmark::RegisterBenchmark((name + "/march_cpu" + at).c_str(), [=](benchmark::State& state) {
            const SparseVoxelOctree tree(**scene, make_voxel_grid((*scene)->bounds, resolution), false);
            march(state, *segments,
                  [&](const Segment& s) { return svo_occluded(tree.view(), s.a, s.normal_a, s.b, s.normal_b); });
        })->UseRealTime();
        // As many lights ask them: some from one point at once.
        benchmark::RegisterBenchmark((name + "/march_cpu_lanes" + at).c_str(), [=](benchmark::State& state) {
            const SparseVoxelOctree tree(**scene, make_voxel_grid((*scene)->bounds, resolution), false);
            march_in_lanes(state, *segments, tree.view());
        })->UseRealTime();
    }
}

}  // namespace
}  // namespace photond

int main(int argc, char** argv) {
    try {
        if (argc > 1 && std::strcmp(argv[1], "errors") == 0) {
            std::vector<uint32_t> resolutions;
            for (int i = 2; i < argc; ++i)
                resolutions.push_back(static_cast<uint32_t>(std::strtoul(argv[i], nullptr, 10)));
            photond::print_errors(resolutions.empty() ? std::vector<uint32_t>{128, 256} : resolutions);
            return 0;
        }
        for (const photond::NamedScene& named : photond::kScenes) photond::register_scene(named);
        benchmark::Initialize(&argc, argv);
        benchmark::RunSpecifiedBenchmarks();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "svo_bench: %s\n", error.what());
        return 1;
    }
}
