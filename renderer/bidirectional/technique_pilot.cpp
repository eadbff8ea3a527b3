#include "renderer/bidirectional/technique_pilot.h"

#include "renderer/bidirectional/eye_paths.h"
#include "renderer/core/thread_local.h"

namespace photond {

namespace {

constexpr uint64_t kPilotSeed = reference_seed(0x9a57);
constexpr uint64_t kPixels = 4096;  // about
constexpr uint32_t kPasses = 4;
constexpr uint32_t kTile = EyePathTracer::kTileSide;
constexpr uint32_t kAround = 2;  // pixels to each side whose mean says how bright it is
/// Of the whole image's mean, squared: what is darker counts as if it were about as bright.
constexpr double kLeastMean = 0.05;

double sqr_of(double x) { return x * x; }

Size2 pilot_size(Size2 size) {
    const double share = std::sqrt(static_cast<double>(kPixels) / static_cast<double>(size.pixels()));
    if (share >= 1) return size;
    const auto scaled = [share](uint32_t side) {
        return std::max(static_cast<uint32_t>(std::lround(share * side)), 1u);
    };
    return {scaled(size.width), scaled(size.height)};
}

/// As the pilot's samples weigh by it.
WeighedCandidate weighed(const TechniqueCandidate& candidate, const PassTechniques& pilot, double vertices_per_path,
                         double pixels) {
    WeighedCandidate result;
    if (!(candidate.light_paths > 0)) {
        result.numbers.connections = 0;
        return result;
    }
    result.numbers = {.light_paths = candidate.light_paths * static_cast<float>(pixels),
                      .connections = static_cast<float>(candidate.connections / vertices_per_path),
                      .merges = candidate.merges};
    if (pilot.own_path) result.numbers.connections = 1;
    result.more_light_paths = pilot.numbers.light_paths / result.numbers.light_paths;
    if (result.numbers.connections > 0)
        result.more_connections = pilot.numbers.connections / result.numbers.connections;
    return result;
}

struct PilotThread {
    EyePathTracer eye;
    Counts counts;
    EyeSeconds seconds;
};

}  // namespace

TechniquePilot run_technique_pilot(const TechniquePilotInputs& inputs, Stats& stats) {
    RenderContext context = inputs.context;
    context.view.film_size = pilot_size(inputs.context.view.film_size);
    context.view.filter = PixelFilter::Box;
    context.view.layers = LayerSet();
    context.seed = hash64(inputs.context.seed) ^ kPilotSeed;
    const BidirectionalScene scene(context, inputs.params);
    const Size2 size = context.view.film_size;
    const auto pixels = static_cast<double>(size.pixels());

    PassTechniques pilot;
    pilot.light_paths = static_cast<uint32_t>(size.pixels());
    pilot.own_path = inputs.params.connections == Connections::OwnPath;
    pilot.correlated = inputs.choices.merges && inputs.params.merging()->correlated();
    pilot.connections_per_vertex = 1;
    // As many vertices are to lie within the radius as in the image's own passes.
    const double denser = static_cast<double>(inputs.context.view.film_size.pixels()) / pixels;
    pilot.merge_radius_m = inputs.choices.merges ? inputs.merge_radius_m * static_cast<float>(std::sqrt(denser)) : 0.0f;
    pilot.edges = inputs.edges;
    pilot.edge_radius_m = inputs.merge_radius_m;
    pilot.edge_share = inputs.edge_share;
    pilot.numbers = {.light_paths = static_cast<float>(pilot.light_paths),
                     .connections = pilot.own_path ? 1 : static_cast<float>(1 / inputs.vertices_per_path),
                     .merges = pilot.merge_radius_m > 0};

    const std::vector<TechniqueCandidate> candidates = technique_candidates(inputs.choices);
    std::vector<WeighedCandidate> weighed_candidates;
    for (const TechniqueCandidate& candidate : candidates)
        weighed_candidates.push_back(weighed(candidate, pilot, inputs.vertices_per_path, pixels));

    LightPathTracer light(scene);
    ThreadLocal<PilotThread> threads;
    const uint32_t columns = (size.width + kTile - 1) / kTile, rows = (size.height + kTile - 1) / kTile;
    std::vector<PixelMoments> moments(size.pixels() * candidates.size());  // pixel after pixel, by candidate
    std::vector<PilotTile> tiles(size_t{columns} * rows);
    PilotCounts counts;
    PassImage image(size, context.view.layers);
    const CancelToken never;
    Counts rays;
    for (uint32_t pass = 0; pass < kPasses; ++pass) {
        LightPaths& paths = light.trace(context.seed, pass, pilot, rays, never, weighed_candidates);
        counts.light_vertices += static_cast<double>(paths.vertices.size());
        counts.seen += static_cast<double>(paths.splats.size());
        std::vector<uint32_t> order(paths.vertices.size());
        std::optional<HashGrid> grid;
        if (pilot.merge_radius_m > 0 && !paths.vertices.empty()) grid.emplace(paths.grid(pilot.merge_radius_m, order));
        if (pilot.own_path) paths.sort_by_path(pilot.light_paths);
        const PassSampler sampler(scene.sampler, context.seed, RandomDomain::Camera, pass);
        const JoinedPass joined{.techniques = pilot,
                                .light = paths,
                                .grid = grid ? &*grid : nullptr,
                                .in_grid_order = order,
                                .sampler = sampler,
                                .connection_salt = hash64(context.seed) + pass,
                                .candidates = weighed_candidates};
        parallel_over_tiles(size, kTile, never, [&](const Tile& tile) {
            PilotThread& mine = threads.local();
            mine.eye.trace_tile(scene, joined, tile, image, mine.counts, mine.seconds,
                                &tiles[(tile.y0 / kTile) * columns + tile.x0 / kTile]);
        });
        for (size_t i = 0; i < tiles.size(); ++i) {
            const auto x0 = static_cast<uint32_t>(i % columns) * kTile, y0 = static_cast<uint32_t>(i / columns) * kTile;
            const uint32_t width = std::min(kTile, size.width - x0);
            for (size_t k = 0; k < tiles[i].paths.size(); ++k) {
                const auto in_tile = static_cast<uint32_t>(k / candidates.size());
                const size_t pixel = size_t{y0 + in_tile / width} * size.width + x0 + in_tile % width;
                const size_t c = k % candidates.size();
                moments[pixel * candidates.size() + c].add(tiles[i].paths[k]);
            }
            counts.eye_vertices += tiles[i].counts.eye_vertices;
            counts.open_vertices += tiles[i].counts.open_vertices;
            counts.found += tiles[i].counts.found;
        }
        for (size_t i = 0; i < paths.splats.size(); ++i)
            scene.filter.visit_pixels(paths.splats[i].film, size, [&](uint32_t pixel, float) {
                for (size_t c = 0; c < candidates.size(); ++c)
                    moments[pixel * candidates.size() + c].add_seen(paths.splat_weights[i * candidates.size() + c] *
                                                                    paths.splats[i].radiance);
            });
    }
    for (PilotThread& thread : threads) rays += thread.counts;
    stats.counts.photon_rays += rays.photon_rays;
    stats.counts.camera_rays += rays.camera_rays;
    stats.counts.bounce_rays += rays.bounce_rays;
    stats.counts.shadow_rays += rays.shadow_rays;
    for (double* count :
         {&counts.eye_vertices, &counts.open_vertices, &counts.light_vertices, &counts.seen, &counts.found})
        *count /= pixels * kPasses;

    // The pilot says how bright it is around each pixel, too.
    const size_t most = candidates.size() - 1;  // of all techniques: its samples are the least noisy
    const auto mean_of_pixel = [&](uint32_t x, uint32_t y) {
        return moments[(size_t{y} * size.width + x) * candidates.size() + most].mean(kPasses);
    };
    double mean = 0;
    for (uint32_t y = 0; y < size.height; ++y)
        for (uint32_t x = 0; x < size.width; ++x) mean += mean_of_pixel(x, y) / pixels;
    std::vector<double> relative_variance(candidates.size());
    for (uint32_t y = 0; y < size.height; ++y)
        for (uint32_t x = 0; x < size.width; ++x) {
            double around = 0;
            uint32_t seen = 0;
            for (uint32_t v = std::max(y, kAround) - kAround; v < std::min(y + kAround + 1, size.height); ++v)
                for (uint32_t u = std::max(x, kAround) - kAround; u < std::min(x + kAround + 1, size.width);
                     ++u, ++seen)
                    around += mean_of_pixel(u, v);
            const double scale = 1 / (sqr_of(around / seen) + kLeastMean * sqr_of(mean) + 1e-30);
            for (size_t c = 0; c < candidates.size(); ++c)
                relative_variance[c] += scale *
                                        moments[(size_t{y} * size.width + x) * candidates.size() + c].variance(
                                            kPasses, weighed_candidates[c]) /
                                        pixels;
        }
    const CostlyScene costly{context.scene.triangle_count, context.scene.needs.only_lambert()};
    TechniquePilot judged{.candidates = {}, .chosen = 0};
    const auto worth = [](const JudgedCandidate& c) { return c.relative_variance * c.cost; };
    for (size_t c = 0; c < candidates.size(); ++c) {
        judged.candidates.push_back(
            {candidates[c], std::max(relative_variance[c], 0.0), counted_cost(candidates[c], counts, costly)});
        if (worth(judged.candidates[c]) < worth(judged.candidates[judged.chosen])) judged.chosen = c;
    }
    return judged;
}

}  // namespace photond
