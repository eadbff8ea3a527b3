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
                      .merges = candidate.merges,
                      .caustic_radius = pilot.everywhere.numbers.caustic_radius};
    if (pilot.own_path) result.numbers.connections = 1;
    result.more_light_paths = pilot.everywhere.numbers.light_paths / result.numbers.light_paths;
    if (result.numbers.connections > 0)
        result.more_connections = pilot.everywhere.numbers.connections / result.numbers.connections;
    return result;
}

/// Blocks of so many of the pilot's pixels a side, or a few more: their variances have to be known.
constexpr double kLeastBlock = 4;

uint32_t block_side(Size2 image, Size2 pilot) {
    const double tiles = kLeastBlock * image.width / pilot.width / kTile;
    return kTile * static_cast<uint32_t>(std::max(1.0, std::ceil(tiles)));
}

/// What candidates would be in the blocks of an image, from what they would be at a pilot's pixels.
class BlockJudge {
public:
    BlockJudge(Size2 image, Size2 pilot, size_t candidates)
        : image_(image),
          pilot_(pilot),
          side_(block_side(image, pilot)),
          count_(TechniqueBlocks::count_of(image, side_)),
          sums_(count_.pixels(), VarianceSums(candidates)),
          pixels_(count_.pixels()),
          counted_(count_.pixels()) {}

    uint32_t side() const { return side_; }
    /// A pixel of the pilot, with what its paths counted.
    void add(uint32_t x, uint32_t y, const VarianceSums& of_pixel, const EyePathCounts& counted) {
        const auto along = [&](uint32_t p, uint32_t of_pilot, uint32_t of_image) {
            const double at = (p + 0.5) * of_image / of_pilot;
            return static_cast<uint32_t>(at) / side_;
        };
        const size_t block =
            along(y, pilot_.height, image_.height) * count_.width + along(x, pilot_.width, image_.width);
        ++pixels_[block];
        counted_[block] += counted;
        sums_[block].add(of_pixel, 1);
    }
    /// The blocks, each judged together with those about it, whose paths are much like its own; `cost(counted, c)` is
    /// of a pixel with these counts of all its passes.
    template <class Cost>
    std::vector<JudgedBlock> judge(uint32_t passes, size_t known, const Cost& cost) const {
        std::vector<JudgedBlock> judged;
        for (uint32_t y = 0; y < count_.height; ++y)
            for (uint32_t x = 0; x < count_.width; ++x) {
                const size_t block = size_t{y} * count_.width + x;
                double pixels = 0;
                PilotCounts counts;
                VarianceSums sums(sums_[block].of_paths.size());
                for (uint32_t v = std::max(y, 1u) - 1; v <= std::min(y + 1, count_.height - 1); ++v)
                    for (uint32_t u = std::max(x, 1u) - 1; u <= std::min(x + 1, count_.width - 1); ++u) {
                        const size_t other = size_t{v} * count_.width + u;
                        const double weight = (u == x ? 2 : 1) * (v == y ? 2 : 1);
                        pixels += weight * pixels_[other];
                        counts.eye_vertices += weight * counted_[other].vertices;
                        counts.open_vertices += weight * counted_[other].open_vertices;
                        counts.found += weight * counted_[other].found;
                        counts.clipped += weight * counted_[other].clipped;
                        sums.add(sums_[other], weight);
                    }
                for (double* count : {&counts.eye_vertices, &counts.open_vertices, &counts.found, &counts.clipped})
                    *count /= std::max(pixels, 1.0) * passes;
                const std::vector<double> variances = sums.variances(known);
                const double of_block = pixels_[block] / std::max(pixels, 1.0);
                for (size_t c = 0; c < variances.size(); ++c)
                    judged.push_back(
                        {.relative_variance = of_block * variances[c], .cost = pixels_[block] * cost(counts, c)});
            }
        return judged;
    }

private:
    Size2 image_, pilot_;
    uint32_t side_;
    Size2 count_;
    std::vector<VarianceSums> sums_;  // block by block
    std::vector<double> pixels_;      // of the pilot
    std::vector<EyePathCounts> counted_;
};

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
    // As many vertices are to lie within the radius as in the image's own passes.
    const double denser = static_cast<double>(inputs.context.view.film_size.pixels()) / pixels;
    pilot.radii = inputs.radii;
    pilot.radius_share = static_cast<float>(std::sqrt(denser));
    pilot.merge_radius_m = inputs.choices.merges ? inputs.merge_radius_m * pilot.radius_share : 0.0f;
    pilot.coverage = inputs.coverage;
    pilot.edge_radius_m = inputs.merge_radius_m;  // as many are cut, too
    pilot.everywhere = {
        .connections_per_vertex = 1,
        .numbers = {.light_paths = static_cast<float>(pilot.light_paths),
                    .connections = pilot.own_path ? 1 : static_cast<float>(1 / inputs.vertices_per_path),
                    .merges = pilot.merge_radius_m > 0,
                    .caustic_radius = inputs.caustic_radius}};

    const std::vector<TechniqueCandidate> candidates = technique_candidates(inputs.choices);
    std::vector<WeighedCandidate> weighed_candidates;
    weighed_candidates.reserve(candidates.size());
    for (const TechniqueCandidate& candidate : candidates)
        weighed_candidates.push_back(weighed(candidate, pilot, inputs.vertices_per_path, pixels));

    LightPathTracer light(scene);
    ThreadLocal<PilotThread> threads;
    const uint32_t columns = (size.width + kTile - 1) / kTile, rows = (size.height + kTile - 1) / kTile;
    std::vector<PixelMoments> moments(size.pixels() * candidates.size());  // pixel after pixel, by candidate
    std::vector<EyePathCounts> counted(size.pixels());
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
                                .join_salt = hash64(context.seed) + pass,
                                .candidates = weighed_candidates};
        parallel_over_tiles(size, kTile, never, [&](const Tile& tile) {
            PilotThread& mine = threads.local();
            mine.eye.trace_tile(scene, joined, tile, image, mine.counts, mine.seconds,
                                &tiles[(tile.y0 / kTile) * columns + tile.x0 / kTile]);
        });
        for (size_t i = 0; i < tiles.size(); ++i) {
            const auto x0 = static_cast<uint32_t>(i % columns) * kTile, y0 = static_cast<uint32_t>(i / columns) * kTile;
            const uint32_t width = std::min(kTile, size.width - x0);
            for (uint32_t in_tile = 0; in_tile < tiles[i].counts.size(); ++in_tile) {
                const size_t pixel = size_t{y0 + in_tile / width} * size.width + x0 + in_tile % width;
                counted[pixel] += tiles[i].counts[in_tile];
                for (size_t c = 0; c < candidates.size(); ++c)
                    moments[pixel * candidates.size() + c].add(tiles[i].paths[in_tile * candidates.size() + c]);
            }
        }
        for (size_t i = 0; i < paths.splats.size(); ++i)
            scene.filter.visit_pixels(paths.splats[i].film, size, [&](uint32_t pixel, float) {
                for (size_t c = 0; c < candidates.size(); ++c)
                    moments[pixel * candidates.size() + c].add_seen(paths.splats[i].radiance,
                                                                    paths.splat_weights[i * candidates.size() + c]);
            });
    }
    for (PilotThread& thread : threads) rays += thread.counts;
    stats.counts.photon_rays += rays.photon_rays;
    stats.counts.camera_rays += rays.camera_rays;
    stats.counts.bounce_rays += rays.bounce_rays;
    stats.counts.shadow_rays += rays.shadow_rays;
    for (const EyePathCounts& of_pixel : counted) {
        counts.eye_vertices += of_pixel.vertices;
        counts.open_vertices += of_pixel.open_vertices;
        counts.found += of_pixel.found;
        counts.clipped += of_pixel.clipped;
    }
    for (double* count : {&counts.eye_vertices, &counts.open_vertices, &counts.light_vertices, &counts.seen,
                          &counts.found, &counts.clipped})
        *count /= pixels * kPasses;

    // The pilot says how bright it is around each pixel, too.
    const size_t most = candidates.size() - 1;  // of all techniques: its samples are the least noisy
    const auto mean_of_pixel = [&](uint32_t x, uint32_t y) {
        return moments[(size_t{y} * size.width + x) * candidates.size() + most].mean(kPasses);
    };
    double mean = 0;
    for (uint32_t y = 0; y < size.height; ++y)
        for (uint32_t x = 0; x < size.width; ++x) mean += mean_of_pixel(x, y) / pixels;
    VarianceSums of_image(candidates.size()), of_pixel(candidates.size());
    BlockJudge blocks(inputs.context.view.film_size, size, candidates.size());
    for (uint32_t y = 0; y < size.height; ++y)
        for (uint32_t x = 0; x < size.width; ++x) {
            double around = 0;
            uint32_t seen = 0;
            for (uint32_t v = std::max(y, kAround) - kAround; v < std::min(y + kAround + 1, size.height); ++v)
                for (uint32_t u = std::max(x, kAround) - kAround; u < std::min(x + kAround + 1, size.width);
                     ++u, ++seen)
                    around += mean_of_pixel(u, v);
            const double scale = 1 / (sqr_of(around / seen) + kLeastMean * sqr_of(mean) + 1e-30);
            const size_t pixel = size_t{y} * size.width + x;
            for (size_t c = 0; c < candidates.size(); ++c) {
                const PixelMoments& of_candidate = moments[pixel * candidates.size() + c];
                of_pixel.of_paths[c] = scale * of_candidate.variance(kPasses, weighed_candidates[c]);
                of_pixel.second_moments[c] = scale * of_candidate.second_moment(kPasses);
            }
            of_image.add(of_pixel, 1 / pixels);
            blocks.add(x, y, of_pixel, counted[pixel]);
        }
    const CostlyScene costly{context.scene.triangle_count, context.scene.needs.only_lambert()};
    const size_t known = most_like_pilot(candidates);
    const std::vector<double> variances = of_image.variances(known);
    TechniquePilot judged{.candidates = {}, .block_side = blocks.side(), .chosen = {}};
    for (size_t c = 0; c < candidates.size(); ++c)
        judged.candidates.push_back({candidates[c], variances[c], counted_cost(candidates[c], counts, costly)});
    judged.chosen = choose_techniques(candidates, blocks.judge(kPasses, known, [&](PilotCounts of_block, size_t c) {
        // Light paths are the whole image's.
        of_block.light_vertices = counts.light_vertices, of_block.seen = counts.seen;
        return counted_cost(candidates[c], of_block, costly);
    }));
    return judged;
}

}  // namespace photond
