// A scene made ready for its next frame, part by part, on the processor's cores: 200,000 triangles of which a tenth
// moves. And what rays cost afterwards, beside rays in a structure that is built anew as if nothing moved.

#include <benchmark/benchmark.h>

#include <random>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/transport/light_sampling.h"
#include "tests/benchmarks/crowd.h"

namespace photond {
namespace {

/// A crowd and its tree, one frame after the other.
class Film {
public:
    Film() { pose_scene(scene, {0, 0}), tree = make_embree_intersector(scene, budget, stats); }

    SceneChange pose() {
        time_ = time_ < 1 ? time_ + 1.0 / 64 : 0;
        return pose_scene(scene, {0, time_});
    }
    void follow(const SceneChange& change) { follow_pose(tree, scene, change, budget, stats); }

    Scene scene = test::make_crowd();
    std::unique_ptr<Intersector> tree;
    MemoryBudget budget;
    Stats stats;

private:
    double time_ = 0;
};

void pose(benchmark::State& state) {
    Film film;
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(film.pose());
    state.counters["triangles"] = static_cast<double>(film.scene.triangle_count);
}
BENCHMARK(pose)->UseRealTime()->Unit(benchmark::kMillisecond);

void tree_follows(benchmark::State& state) {
    Film film;
    for ([[maybe_unused]] auto _ : state) {
        state.PauseTiming();
        const SceneChange change = film.pose();
        state.ResumeTiming();
        film.follow(change);
    }
}
BENCHMARK(tree_follows)->UseRealTime()->Unit(benchmark::kMillisecond);

void tree_anew(benchmark::State& state) {
    Film film;
    for ([[maybe_unused]] auto _ : state) film.tree = make_embree_intersector(film.scene, film.budget, film.stats);
}
BENCHMARK(tree_anew)->UseRealTime()->Unit(benchmark::kMillisecond);

void light_tables(benchmark::State& state) {
    Film film;
    for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(LightSampler(film.scene));
}
BENCHMARK(light_tables)->UseRealTime()->Unit(benchmark::kMillisecond);

/// All of these, as a worker does them.
void next_frame(benchmark::State& state) {
    Film film;
    for ([[maybe_unused]] auto _ : state) {
        film.follow(film.pose());
        benchmark::DoNotOptimize(LightSampler(film.scene));
    }
}
BENCHMARK(next_frame)->UseRealTime()->Unit(benchmark::kMillisecond);

/// Rays from everywhere to everywhere. `state.range(0)`: in the tree that followed, or in one of a scene of the same
/// triangles that has no rig.
void rays(benchmark::State& state) {
    Film film;
    for (int frame = 0; frame < 20; ++frame) film.follow(film.pose());
    Scene still = film.scene;
    still.rig = nullptr;
    const std::unique_ptr<Intersector> anew = make_embree_intersector(still, film.budget, film.stats);
    const Intersector& tree = state.range(0) ? *film.tree : *anew;
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(-1, 1);
    const auto any = [&] { return vec3(uniform(random), uniform(random), uniform(random)); };
    std::vector<Ray> asked(1 << 16);
    for (Ray& ray : asked) ray = {any() * vec3(11, 4, 11), glm::normalize(any())};
    std::vector<Hit> hits(asked.size());
    for ([[maybe_unused]] auto _ : state) tree.closest_hits(asked, hits, Coherence::Incoherent);
    state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(asked.size()));
}
BENCHMARK(rays)->ArgName("followed")->Arg(1)->Arg(0)->Arg(1)->Arg(0)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace photond

BENCHMARK_MAIN();
