// Rays a second through the device's ray structure, and what building it costs: camera rays, the rays a Lambert surface
// scatters where those hit, and shadow rays from there to random points of the scene's lights (of its box where it has
// none). Masked surfaces count as whole. On a software device the rate a processor second is steadier than the rate a
// second.
//
//     gpu_rays_bench [scene ...]      a built-in scene's name, or a file of the scene folder; default: some of each

#include <cstdio>
#include <ctime>

#include "renderer/backends/gpu/bvh.h"
#include "renderer/backends/gpu/scene_bindings.h"
#include "renderer/core/rng.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/sampling.h"
#include "tests/benchmarks/bench_scenes.h"
#include "tests/support/gpu_twin.h"

namespace photond {
namespace {

constexpr int kRuns = 3;

double processor_seconds() {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

struct RaySet {
    const char* name;
    bool any;
    std::vector<Ray> rays;
};

std::vector<RaySet> make_rays(const Scene& scene, const gpu::BvhData& bvh, Size2 size) {
    const Camera camera = find_camera(scene, "");
    RandomStream random(1, RandomDomain::Test, 0, 0);
    RaySet eye{"primary", false, {}}, bounce{"diffuse bounce", false, {}}, shadow{"shadow", true, {}};
    // By tiles of 8 x 8, as methods take their pixels.
    for (uint32_t i = 0; i < size.pixels(); ++i) {
        const uint32_t tile = i / 64, tiles = size.width / 8;
        const vec2 pixel(float(tile % tiles * 8 + i % 8), float(tile / tiles * 8 + i % 64 / 8));
        eye.rays.push_back(camera_ray(camera, size, pixel + random.next_2d(), vec2(0.5f)));
    }
    for (const Ray& ray : eye.rays) {
        const Hit hit = gpu::closest_hit(bvh, scene, ray);
        if (!hit.valid()) continue;
        const TriangleCorners c = world_triangle(scene, hit.instance, hit.triangle);
        vec3 n = glm::normalize(glm::cross(c.p[1] - c.p[0], c.p[2] - c.p[0]));
        if (glm::dot(n, ray.direction) > 0) n = -n;
        const vec3 p = offset_ray_origin((1 - hit.u - hit.v) * c.p[0] + hit.u * c.p[1] + hit.v * c.p[2], n);
        const vec3 local = sample_cosine_hemisphere(random.next_2d());
        bounce.rays.push_back({p, Frame(n).to_world(local)});
        vec3 target = scene.bounds.min + vec3(random.next_2d(), random.next()) * scene.bounds.diagonal();
        if (const size_t lights = scene.triangle_lights.size(); lights > 0) {
            const TriangleLight& light = scene.triangle_lights[random.next_bits() % lights];
            const TriangleCorners l = world_triangle(scene, light.instance, light.triangle);
            const vec2 u = random.next_2d();
            const float root = std::sqrt(u.x);
            target = (1 - root) * l.p[0] + root * (1 - u.y) * l.p[1] + root * u.y * l.p[2];
        }
        const float distance = glm::distance(p, target);
        shadow.rays.push_back({p, (target - p) / distance, 0.999f * distance});
    }
    return {eye, bounce, shadow};
}

void measure(const Scene& scene, const char* name, Size2 size) {
    const gpu::BvhData bvh = gpu::build_bvh(scene);
    const uint64_t stored = std::max<uint64_t>(scene.triangle_count, 1);
    std::printf("%s: %llu triangles, %.1f bytes a triangle, %zu nodes, stack %u, built in %.0f ms\n", name,
                static_cast<unsigned long long>(scene.triangle_count), double(bvh.bytes()) / double(stored),
                bvh.nodes.size(), bvh.stack_entries, 1e3 * bvh.build_seconds);
    const test::PartOfScene part({{BVH_NODES_BINDING, std::as_bytes(std::span(bvh.nodes))},
                                  {BVH_TRIANGLES_BINDING, std::as_bytes(std::span(bvh.triangles))}});
    for (const RaySet& set : make_rays(scene, bvh, size)) {
        gpu::Device& device = test::gpu_device();
        const gpu::ComputePipeline pipeline(
            device, "tests/gpu/bvh_rays.comp", sizeof(uint32_t), &part.set(),
            {gpu::specialize(1, false), gpu::specialize(BVH_TWO_LEVELS_ID, bvh.two_levels),
             gpu::specialize(32, set.any)});
        gpu::Buffer rays = gpu::make_buffer(device, "rays", std::span(set.rays));
        gpu::Buffer answers(device, "answers", set.rays.size() * sizeof(float));
        std::vector<double> seconds, processor;
        for (int run = 0; run < kRuns; ++run) {
            gpu::CommandList commands(device);
            commands.bind(pipeline, {gpu::read("rays", rays), gpu::write("answers", answers)});
            commands.push(static_cast<uint32_t>(set.rays.size()));
            commands.begin_scope(set.name);
            commands.dispatch_threads(set.rays.size(), 64);
            commands.end_scope();
            const double before = processor_seconds();
            commands.submit();
            commands.wait();
            processor.push_back(processor_seconds() - before);
            seconds.push_back(commands.times().front().seconds);
        }
        const double millions = 1e-6 * double(set.rays.size());
        std::printf("  %-16s %8.3f Mrays/s  %8.3f Mrays a processor second\n", set.name, millions / median(seconds),
                    millions / median(processor));
    }
}

}  // namespace
}  // namespace photond

int main(int argc, char** argv) {
    setenv("PHOTOND_GPU_VALIDATION", "0", 0);
    using namespace photond;
    std::vector<std::string> names(argv + 1, argv + argc);
    if (names.empty())
        names = {"cornell-box", "interior", "cornell_dragon_buddha.glb", "sibenik.glb", "sponza_crytek.glb"};
    for (const std::string& name : names) {
        const NamedScene named{name.c_str(), name.ends_with(".glb") ? name.c_str() : nullptr, {512, 512}};
        if (const std::optional<Scene> scene = open(named)) measure(*scene, named.name, named.size);
    }
}
