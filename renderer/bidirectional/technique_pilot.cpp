#include "renderer/bidirectional/technique_pilot.h"

#include "renderer/bidirectional/eye_paths.h"
#include "renderer/core/thread_local.h"

namespace photond {

namespace {

constexpr uint64_t kPilotSeed = reference_seed(0x9a57);
constexpr uint64_t kPixels = 4096;  // about
constexpr uint32_t kPasses = 4;
constexpr uint32_t kTile = EyePathTracer::kTileSide;
/// Of the whole image's mean: blocks that are darker count as if they were as bright.
constexpr double kLeastMean = 0.05;

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
    std::vector<CandidateMoments> blocks(size_t{columns} * rows, CandidateMoments(candidates.size()));
    std::vector<PilotTile> tiles(blocks.size());
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
        for (size_t i = 0; i < blocks.size(); ++i) {
            blocks[i] += tiles[i].moments;
            counts.eye_vertices += tiles[i].counts.eye_vertices;
            counts.open_vertices += tiles[i].counts.open_vertices;
            counts.found += tiles[i].counts.found;
        }
        for (size_t i = 0; i < paths.splats.size(); ++i) {
            const LightSplat& splat = paths.splats[i];
            scene.filter.visit_pixels(splat.film, size, [&](uint32_t pixel, float) {
                const uint32_t x = pixel % size.width / kTile, y = pixel / size.width / kTile;
                blocks[y * columns + x].add(
                    TechniqueKind::Seen, splat.radiance,
                    std::span(paths.splat_weights).subspan(i * candidates.size(), candidates.size()),
                    weighed_candidates);
            });
        }
    }
    for (PilotThread& thread : threads) rays += thread.counts;
    stats.counts.photon_rays += rays.photon_rays;
    stats.counts.camera_rays += rays.camera_rays;
    stats.counts.bounce_rays += rays.bounce_rays;
    stats.counts.shadow_rays += rays.shadow_rays;
    for (double* count :
         {&counts.eye_vertices, &counts.open_vertices, &counts.light_vertices, &counts.seen, &counts.found})
        *count /= pixels * kPasses;

    // What the pilot itself did says how bright each block is.
    const auto tried = static_cast<size_t>(
        std::find_if(candidates.begin(), candidates.end(), [](const auto& c) { return c.light_paths > 0; }) -
        candidates.begin());
    const auto pixel_passes_of = [&](size_t block) {
        const auto x0 = static_cast<uint32_t>(block % columns) * kTile,
                   y0 = static_cast<uint32_t>(block / columns) * kTile;
        return double(std::min(kTile, size.width - x0)) * double(std::min(kTile, size.height - y0)) * kPasses;
    };
    double mean = 0;
    for (size_t b = 0; b < blocks.size(); ++b)
        mean += blocks[b].mean(tried, pixel_passes_of(b)) * pixel_passes_of(b) / (pixels * kPasses);
    const CostlyScene costly{context.scene.triangle_count, context.scene.needs.only_lambert()};
    TechniquePilot judged{.candidates = {}, .chosen = 0};
    const auto worth = [](const JudgedCandidate& c) { return c.relative_variance * c.cost; };
    for (size_t c = 0; c < candidates.size(); ++c) {
        double variance = 0;
        for (size_t b = 0; b < blocks.size(); ++b) {
            const double of_block = blocks[b].mean(tried, pixel_passes_of(b));
            variance += pixel_passes_of(b) * blocks[b].variance(c, pixel_passes_of(b)) /
                        (of_block * of_block + kLeastMean * mean * mean + 1e-30);
        }
        judged.candidates.push_back(
            {candidates[c], variance / (pixels * kPasses), counted_cost(candidates[c], counts, costly)});
        if (worth(judged.candidates[c]) < worth(judged.candidates[judged.chosen])) judged.chosen = c;
    }
    return judged;
}

}  // namespace photond
