// Speed of looking up photons: the k nearest by our kd-tree, and all within a radius by our hash grid, against the same
// by nanoflann's kd-tree. Prints tables; nothing passes or fails here, but every structure's answers are first held
// against a loop over all photons.
//
// The photons are those of photon_mapping's global map; the queries are first hits of camera rays, once in random order
// and once as an eye pass asks for them, by tiles of 16 x 16 pixels. One thread, CPU time, medians of rounds that take
// turns. nanoflann has the best of its leaf sizes 10, 20, 40 and 80 for each column, searches unsorted, and answers
// into arrays that are reused. FIGURES
//
// Usage: photon_lookup_bench [photons ...]; 200000 and 2000000 without arguments.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iterator>
#include <memory>
#include <nanoflann.hpp>
#include <stdexcept>
#include <string>

#include "renderer/backends/cpu/embree_intersector.h"
#include "renderer/core/rng.h"
#include "renderer/core/stats.h"
#include "renderer/photons/hash_grid.h"
#include "renderer/photons/kd_tree.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/scene/builtin_scenes.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/surface.h"

namespace photond {
namespace {

constexpr uint32_t kNearest = 50;
constexpr uint32_t kFound[] = {20, 50, 200};  // that a search within the radius finds on average
constexpr size_t kLeafSizes[] = {10, 20, 40, 80};
constexpr uint32_t kSeed = 1;

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
    return values[values.size() / 2];
}

std::vector<vec3> trace_photons(const Scene& scene, const Intersector& intersector, size_t count) {
    const EmissionSampler emission(scene);
    const PhotonTracer tracer(scene, intersector, emission, {});
    std::vector<vec3> positions;
    for (uint32_t pass = 0; positions.size() < count; ++pass) {
        const TracedPhotons traced = tracer.trace(kSeed, pass, CancelToken{});
        if (traced.photons.empty()) throw std::runtime_error("the scene takes no photons");
        for (const Photon& photon : traced.photons)
            if (positions.size() < count) positions.push_back(photon.position);
    }
    return positions;
}

/// First hits of camera rays, tile by tile.
std::vector<vec3> eye_points(const Scene& scene, const Intersector& intersector) {
    constexpr uint32_t kTile = 16, kTiles = 16;  // to a side
    const Size2 size{kTile * kTiles, kTile * kTiles};
    const CameraRays rays(find_camera(scene, ""), size);
    RandomStream random(kSeed, RandomDomain::Test, 0, 0);
    std::vector<vec3> points;
    for (uint32_t i = 0; i < size.pixels(); ++i) {
        const uint32_t tile = i / (kTile * kTile), pixel = i % (kTile * kTile);
        const uvec2 corner = kTile * uvec2(tile % kTiles, tile / kTiles);
        const vec2 film = vec2(corner + uvec2(pixel % kTile, pixel / kTile)) + random.next_2d();
        const Ray ray = rays(film, vec2(0.5f));
        const Hit hit = intersector.closest_hit(ray);
        if (hit.valid()) points.push_back(make_shading_point(scene, hit, ray.direction).position);
    }
    return points;
}

std::vector<vec3> shuffled(std::vector<vec3> points) {
    RandomStream random(kSeed, RandomDomain::Test, 1, 0);
    for (size_t i = points.size(); i > 1; --i) std::swap(points[i - 1], points[random.next_bits() % i]);
    return points;
}

/// nanoflann's view of the photons.
struct PointSet {
    std::span<const vec3> points;
    size_t kdtree_get_point_count() const { return points.size(); }
    float kdtree_get_pt(size_t i, size_t axis) const { return (&points[i].x)[axis]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
        return false;
    }
};
using NanoflannTree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, PointSet>, PointSet, 3, uint32_t>;

/// nanoflann as one would use it, with the same results as ours.
class Nanoflann {
public:
    Nanoflann(std::span<const vec3> points, size_t leaf_size)
        : points_{points}, tree_(3, points_, nanoflann::KDTreeSingleIndexAdaptorParams(leaf_size)) {}

    size_t find_nearest(const vec3& p, uint32_t k) {
        indices_.resize(k);
        distances_.resize(k);
        return tree_.knnSearch(&p.x, k, indices_.data(), distances_.data());
    }
    size_t find_within(const vec3& p, float radius_m) {
        static const nanoflann::SearchParams kUnsorted(32, 0, false);
        return tree_.radiusSearch(&p.x, radius_m * radius_m, found_, kUnsorted);
    }

    const std::vector<float>& distances() const { return distances_; }

private:
    PointSet points_;
    NanoflannTree tree_;
    std::vector<uint32_t> indices_;
    std::vector<float> distances_;
    std::vector<std::pair<uint32_t, float>> found_;
};

/// The radius within which that many photons are found on average.
float radius_for(const KdTree& tree, std::span<const vec3> queries, uint32_t found) {
    Neighbours scratch;
    std::vector<float> distances_sq;
    const size_t step = std::max<size_t>(queries.size() / 1000, 1);
    size_t asked = 0;
    for (size_t i = 0; i < queries.size(); i += step, ++asked) {
        tree.find_nearest(queries[i], 20 * found, kInfinity, scratch);
        for (const Neighbours::Found& neighbour : scratch.found) distances_sq.push_back(neighbour.distance_sq_m2);
    }
    const auto last = distances_sq.begin() + std::ptrdiff_t(asked * found);
    std::nth_element(distances_sq.begin(), last, distances_sq.end());
    return std::sqrt(*last);
}

void require(bool holds, const char* what) {
    if (!holds) throw std::runtime_error(what);
}

/// Every structure's answers to some of the queries against all the photons.
void check(std::span<const vec3> photons, std::span<const vec3> queries, const KdTree& tree, const HashGrid& grid,
           Nanoflann& nanoflann) {
    Neighbours found;
    const auto distances_of = [&] {
        std::vector<float> distances_sq;
        for (const Neighbours::Found& neighbour : found.found) distances_sq.push_back(neighbour.distance_sq_m2);
        std::sort(distances_sq.begin(), distances_sq.end());
        return distances_sq;
    };
    for (size_t i = 0; i < queries.size(); i += queries.size() / 40 + 1) {
        const vec3 p = queries[i];
        std::vector<float> all(photons.size());
        for (size_t j = 0; j < all.size(); ++j) {
            const vec3 apart = photons[j] - p;
            all[j] = length_sq(apart.x, apart.y, apart.z);
        }
        std::vector<float> within;
        std::copy_if(all.begin(), all.end(), std::back_inserter(within),
                     [&](float d) { return d < grid.radius_m() * grid.radius_m(); });
        std::sort(within.begin(), within.end());
        std::partial_sort(all.begin(), all.begin() + kNearest, all.end());

        tree.find_nearest(p, kNearest, kInfinity, found);
        require(found.radius_m == std::sqrt(all[kNearest - 1]), "the kd-tree's radius is wrong");
        require(distances_of() == std::vector<float>(all.begin(), all.begin() + kNearest - 1),
                "the kd-tree's answer is wrong");
        require(nanoflann.find_nearest(p, kNearest) == kNearest, "nanoflann found too few");
        for (uint32_t j = 0; j < kNearest; ++j)  // which rounds in another order
            require(std::fabs(nanoflann.distances()[j] - all[j]) <= 1e-5f * all[j], "nanoflann's answer is wrong");

        grid.find_within(p, grid.radius_m(), found);
        require(distances_of() == within, "the hash grid's answer is wrong");
    }
}

/// Ways to answer the same queries, timed in turns.
class Contest {
public:
    explicit Contest(std::span<const vec3> queries) : queries_(queries) {}

    /// search(p) returns how many it found.
    template <class Search>
    void add(Search search) {
        ways_.push_back({[this, search]() mutable {
            size_t found = 0;
            for (const vec3& p : queries_) found += search(p);
            return found;
        }});
    }

    void run(int rounds) {
        for (int round = 0; round < rounds; ++round)
            for (Way& way : ways_) {
                const double start = cpu_now_seconds();
                way.found = way.run();
                way.ns.push_back(1e9 * (cpu_now_seconds() - start) / double(queries_.size()));
            }
    }
    double ns(size_t way) const { return median(ways_[way].ns); }
    double mean_found(size_t way) const { return double(ways_[way].found) / double(queries_.size()); }

    /// Of the ways from the second on, the fastest.
    size_t best_rival() const {
        size_t best = 1;
        for (size_t way = 2; way < ways_.size(); ++way)
            if (ns(way) < ns(best)) best = way;
        return best;
    }
    void print(const char* what) const {
        const size_t rival = best_rival();
        std::printf("  %-28s found %6.1f | ours %7.0f ns | nanoflann %7.0f ns (leaves of %zu) | ratio %5.2f\n", what,
                    mean_found(0), ns(0), ns(rival), kLeafSizes[rival - 1], ns(rival) / ns(0));
    }

private:
    struct Way {
        std::function<size_t()> run;
        std::vector<double> ns;
        size_t found = 0;
    };
    std::span<const vec3> queries_;
    std::vector<Way> ways_;
};

struct Seconds {
    double wall, cpu;
};
template <class Work>
Seconds median_seconds(const Work& work) {
    std::vector<double> wall, cpu;
    for (int round = 0; round < 5; ++round) {
        const double wall_start = wall_now_seconds(), cpu_start = cpu_now_seconds();
        work();
        wall.push_back(wall_now_seconds() - wall_start);
        cpu.push_back(cpu_now_seconds() - cpu_start);
    }
    return {median(wall), median(cpu)};
}

void measure_builds(std::span<const vec3> photons, float radius_m) {
    std::vector<uint32_t> order(photons.size());
    const Seconds tree = median_seconds([&] { KdTree(photons, order); });
    const Seconds grid = median_seconds([&] { HashGrid(photons, radius_m, order); });
    const Seconds nanoflann = median_seconds([&] { Nanoflann(photons, 10); });
    std::printf("  build seconds (wall, CPU): kd-tree %.3f %.3f, hash grid %.3f %.3f, nanoflann %.3f %.3f\n", tree.wall,
                tree.cpu, grid.wall, grid.cpu, nanoflann.wall, nanoflann.cpu);
}

void measure(const char* name, size_t count) {
    const Scene scene = make_builtin_scene(name);
    MemoryBudget budget;
    Stats stats;
    const auto intersector = make_embree_intersector(scene, budget, stats);
    const std::vector<vec3> photons = trace_photons(scene, *intersector, count);
    const std::vector<vec3> tiles = eye_points(scene, *intersector);
    std::printf("\n%s, %zu photons, %zu queries\n", name, photons.size(), tiles.size());

    std::vector<uint32_t> order(photons.size());
    const KdTree tree(photons, order);
    std::vector<std::unique_ptr<Nanoflann>> rivals;
    for (const size_t leaf_size : kLeafSizes) rivals.push_back(std::make_unique<Nanoflann>(photons, leaf_size));
    measure_builds(photons, radius_for(tree, tiles, kNearest));

    const std::vector<vec3> random = shuffled(tiles);
    for (const auto& [queries, order_name] : {std::pair(&random, "random order"), std::pair(&tiles, "tiles")}) {
        Neighbours scratch;
        Contest nearest(*queries);
        nearest.add([&](const vec3& p) {
            tree.find_nearest(p, kNearest, kInfinity, scratch);
            return scratch.found.size() + 1;
        });
        for (const auto& rival : rivals) nearest.add([&](const vec3& p) { return rival->find_nearest(p, kNearest); });
        nearest.run(7);
        nearest.print((std::to_string(kNearest) + " nearest, " + order_name).c_str());

        for (const uint32_t found : kFound) {
            const float radius_m = radius_for(tree, tiles, found);
            std::vector<uint32_t> grid_order(photons.size());
            const HashGrid grid(photons, radius_m, grid_order);
            check(photons, *queries, tree, grid, *rivals.front());
            Contest within(*queries);
            within.add([&](const vec3& p) {
                grid.find_within(p, radius_m, scratch);
                return scratch.found.size();
            });
            for (const auto& rival : rivals) within.add([&](const vec3& p) { return rival->find_within(p, radius_m); });
            within.run(5);
            char what[64];
            std::snprintf(what, sizeof what, "within %.4f m, %s", double(radius_m), order_name);
            within.print(what);
        }

        const double start = cpu_now_seconds();
        size_t sum = 0;
        for (const vec3& p : *queries) sum += tree.find_one(p, kInfinity, [](uint32_t) { return true; });
        const double seconds = cpu_now_seconds() - start;
        std::printf("  %-28s %.0f ns (checksum %zu)\n", (std::string("find_one, ") + order_name).c_str(),
                    1e9 * seconds / double(queries->size()), sum);
    }
}

}  // namespace
}  // namespace photond

int main(int argc, char** argv) {
    try {
        std::vector<size_t> counts;
        for (int i = 1; i < argc; ++i) counts.push_back(std::strtoull(argv[i], nullptr, 10));
        if (counts.empty()) counts = {200'000, 2'000'000};
        for (const size_t count : counts)
            for (const char* scene : {"cornell-box", "interior"}) photond::measure(scene, count);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "photon_lookup_bench: %s\n", error.what());
        return 1;
    }
}
