#include "renderer/methods/photon_splatting/photon_splatting.h"

#include <map>

#include "renderer/core/thread_local.h"
#include "renderer/eye/specular_walk.h"
#include "renderer/gbuffer/indirect_blur.h"
#include "renderer/many_lights/clamp_repayment.h"
#include "renderer/methods/photon_splatting/splat_accumulation.h"
#include "renderer/methods/photon_splatting/splat_pilot.h"

namespace photond {

namespace {

constexpr uint32_t kTileSide = 32;
constexpr float kSplitRadii = 0.75f;  // clusters wider than that are halved

/// Photons a light path leaves at its first scattering, and at each further one of those it leaves at the one before,
/// where nothing is known of the scene, a furnished closed room.
constexpr double kExpectedYield = 0.6;

double expected_photons(const PhotonSplattingParams& params) {
    const double lost = std::pow(kExpectedYield, std::max(params.bounces, 1u));
    return params.photons * kExpectedYield * (1 - lost) / (1 - kExpectedYield);
}
uint64_t photon_bytes(const PhotonSplattingParams& params) {
    return static_cast<uint64_t>(expected_photons(params)) * sizeof(ReflectedPhoton);
}

/// A pixel has one visible point at most but where glossy parts are followed. Places that are left over, and what
/// surfaces that are not Lambert take beside, as built-in scenes have it.
uint64_t point_bytes(Size2 size, const Needs& needs) {
    constexpr double kSlack = 1.3, kGeneral = 0.3;
    const double general = needs.only_lambert() ? 0 : kGeneral * sizeof(VisiblePoint);
    const double of_point = kSlack * sizeof(PointBlock) / kLanes + sizeof(VisibleCluster) / 16.0 + general;
    return static_cast<uint64_t>(of_point * static_cast<double>(size.pixels()));
}

/// Pairs of clusters and splats are most of it: about a ray in a room lie so many clusters. Measured in the built-in
/// scenes from 64x64 to 800x600 pixels; fewer splats of whole cells are as much wider, but lie over one another. Open
/// scenes have half of that.
uint64_t batch_bytes(const PhotonSplattingParams& params, Size2 size) {
    constexpr double kClustersOfRootPixel = 0.22, kStratified = 0.7, kSlack = 1.5;
    const size_t at_once = std::max<size_t>(SplatBatch::kSplats, params.rays_per_photon);
    const double splats =
        std::min(static_cast<double>(expected_photons(params)) * params.rays_per_photon, static_cast<double>(at_once));
    const double clusters = kClustersOfRootPixel * std::sqrt(static_cast<double>(size.pixels()));
    const double of_splat =
        kSlack * sizeof(Splat) + clusters * (sizeof(SplatBatch::Pair) + sizeof(SplatBatch::Chunk::Found));
    return static_cast<uint64_t>(splats * of_splat * (params.stratify ? kStratified : 1));
}

}  // namespace

struct PhotonSplatting::State {
    struct PerThread {
        SpecularWalk walk{kTileSide};
        ClusterBuilder builder;
        std::vector<VisibleCluster> clusters;
        SplatAccumulator accumulator;
        ClampRepayment repayment;
        std::vector<ClampedPoint> clamped;
        std::vector<Rgb> repaid;
        Counts counts;
        EyeSeconds seconds;
        double splat_seconds = 0, repay_seconds = 0;
    };

    State(const RenderContext& context, const PhotonSplattingParams& params)
        : eye(context, params.sampler, params.max_scatterings()),
          settings(params, context.scene),
          budget(context.budget),
          image(context.view.film_size, context.view.layers) {
        const Size2 size = context.view.film_size;
        columns = (size.width + kTileSide - 1) / kTileSide;
        tiles.resize(size_t{columns} * ((size.height + kTileSide - 1) / kTileSide));
    }

    /// Nothing that the clamp may take anything from: no short ray of the cluster's points would meet a surface.
    bool nothing_near(const VisibleCluster& cluster) const {
        return shafts && cluster.flat() &&
               !shafts->near_above(cluster.target, std::sqrt(cluster.clamp_sq_m2()), cluster.target.centre,
                                   cluster.target.normal);
    }
    uint32_t tile_index(const Tile& tile) const { return tile.y0 / kTileSide * columns + tile.x0 / kTileSide; }
    /// A structure of this pass: what is reported is the greatest of all passes.
    void record(const std::string& structure, uint64_t bytes) {
        uint64_t& most = most_bytes[structure];
        most = std::max(most, bytes);
        budget.record(structure, most);
    }

    EyeScene eye;
    const SplatSettings settings;
    MemoryBudget& budget;
    std::optional<EmissionSampler> emission;
    std::optional<PhotonTracer> tracer;
    std::optional<ShaftVisibility> shafts;
    PilotSizes sizes{SplatSizes(settings.radius_m), BeamSizes(settings.beam_radius_m)};
    ThreadLocal<PerThread> threads;
    std::map<std::string, uint64_t> most_bytes;

    uint32_t columns = 0;
    std::vector<PointTile> tiles;
    VisibleClusters clusters;
    TracedReflections photons;  // of the pass
    std::vector<SplatSource> sources;
    SplatBatch batch;
    std::vector<vec3> blur_normal;
    std::vector<float> blur_depth;
    PassImage image;
    bool pass_complete = false;  // image holds a whole pass
};

PhotonSplatting::PhotonSplatting(const PhotonSplattingParams& params) : params_(params) {}
PhotonSplatting::~PhotonSplatting() = default;

uint64_t PhotonSplatting::estimate_bytes(const PhotonSplattingParams& params, const Workload& workload) {
    const bool lights = workload.lights > 0 || workload.environment_size.pixels() > 0;
    uint64_t bytes = PassImage::bytes_for(workload.film_size, workload.layers) +
                     workload.threads * SpecularWalk::bytes_per_thread(kTileSide) +
                     LightSampler::estimate_bytes(workload.lights, workload.environment_size) +
                     point_bytes(workload.film_size, workload.needs);
    if (params.blur_edges && params.blur != BlurWidth::None)
        bytes += workload.film_size.pixels() * (sizeof(vec3) + sizeof(float));
    if (!lights || params.bounces == 0) return bytes;
    bytes += EmissionSampler::estimate_bytes(workload.lights, workload.environment_size) +
             PhotonTracer::scratch_bytes(workload.threads) + workload.threads * SplatAccumulator::bytes_per_thread() +
             photon_bytes(params) + batch_bytes(params, workload.film_size);
    if (params.stratify) bytes += stratification_bytes(photon_bytes(params) / sizeof(ReflectedPhoton));
    if (params.connects() && params.visibility) bytes += ShaftVisibility::estimate_bytes(workload.triangles);
    return bytes;
}

void PhotonSplatting::begin(const RenderContext& context, Stats& stats) {
    const Scene& scene = context.scene;
    const uint64_t lights = scene.triangle_lights.size() + scene.punctual_lights.size();
    const Size2 environment = scene.environment ? scene.environment->map.size : Size2{};
    const Workload workload{context.view.film_size,
                            context.view.layers,
                            unsigned(most_threads()),
                            lights,
                            environment,
                            scene.triangle_count,
                            scene.needs,
                            {}};
    context.budget.require("photon_splatting", estimate_bytes(params_, workload));

    state_ = std::make_unique<State>(context, params_);
    State& state = *state_;
    MemoryBudget& budget = context.budget;
    budget.record("pass_image", PassImage::bytes_for(context.view.film_size, context.view.layers));
    budget.record("wavefronts", most_threads() * SpecularWalk::bytes_per_thread(kTileSide));
    budget.record("light_sampler", state.eye.lights.bytes());

    const char* nothing = params_.bounces == 0       ? "bounces is 0"
                          : state.eye.lights.empty() ? "the scene has no light"
                                                     : nullptr;
    if (!nothing) {
        const StageTimer timer(stats, "photon_emission");
        state.emission = emission_of(scene);
        if (!state.emission) nothing = "the scene has no light";
    }
    const uint64_t shaft_bytes = ShaftVisibility::estimate_bytes(scene.triangle_count);
    if (nothing) {
        stats.skipped.push_back(
            {"splats", nothing, photon_bytes(params_) + batch_bytes(params_, context.view.film_size)});
        stats.skipped.push_back({"shaft visibility", nothing, shaft_bytes});
        return;
    }
    budget.record("emission_sampler", state.emission->bytes());
    budget.record("photon_tracer", PhotonTracer::scratch_bytes(most_threads()));
    budget.record("splat_accumulators", most_threads() * SplatAccumulator::bytes_per_thread());
    const PhotonTracing tracing{.photons = params_.photons,
                                .most_scatterings = params_.bounces,
                                .glossy_threshold = params_.photon_threshold(),
                                .sampler = params_.sampler,
                                .injection = params_.injection,
                                .rough_apart = params_.connects()};
    state.tracer.emplace(scene, *context.intersector, *state.emission, tracing);
    const auto skip_shafts = [&](const char* why, uint64_t bytes) {
        stats.skipped.push_back({"shaft visibility", why, bytes});
    };
    if (!params_.connects())
        skip_shafts("it is for connections", shaft_bytes);
    else if (!params_.visibility)
        skip_shafts("visibility is off", shaft_bytes);
    else if (scene.triangle_count > ShaftVisibility::kMostTriangles)
        skip_shafts("too many triangles", 0);
    else {
        const StageTimer timer(stats, "shaft_build");
        state.shafts.emplace(scene);
        budget.record("shaft_visibility", state.shafts->bytes());
    }
    {
        const StageTimer timer(stats, "photon_tracing");
        state.sizes = sizes_by_pilot(state.settings, params_, scene, *context.intersector, *state.emission, tracing,
                                     context.seed, stats);
        budget.record("splat_sizes", state.sizes.splats.bytes() + state.sizes.beams.bytes());
    }
    if (params_.connects() && !scene.needs.delta && !scene.needs.glossy)
        stats.skipped.push_back({"depth maps of beams", "no surface reflects but by its rough part", 0});
    if (!scene.needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});
}

void PhotonSplatting::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    state_->pass_complete = false;
    look_from_eye(pass, stats, cancel);
    if (cancel.cancelled()) return;
    splat_photons(pass, stats, cancel);
    if (cancel.cancelled()) return;
    light_image(pass, stats, cancel);
    if (cancel.cancelled()) return;
    blur(stats);
    state_->pass_complete = true;
}

/// Direct light, and the visible points in clusters.
void PhotonSplatting::look_from_eye(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    const double wall_start = wall_now_seconds();
    const PassSampler sampler(state.eye.sampler, state.eye.seed, RandomDomain::Camera, pass);
    const WalkSettings settings{.glossy_threshold = params_.glossy_threshold};
    const float split_extent_m = kSplitRadii * state.settings.radius_m;
    std::vector<std::vector<VisibleCluster>> of_tile(state.tiles.size());
    parallel_over_tiles(state.eye.view.film_size, kTileSide, cancel, [&](const Tile& tile) {
        State::PerThread& mine = state.threads.local();
        const uint32_t index = state.tile_index(tile);
        mine.clusters.clear();
        mine.builder.start(tile, index, state.eye.view.film_size, state.eye.max_scatterings, split_extent_m,
                           state.tiles[index], mine.clusters);
        mine.walk.trace_tile(state.eye, settings, {sampler, std::span(&sampler, 1)}, tile, state.image, mine.counts,
                             mine.seconds, cancel, mine.builder);
        of_tile[index] = mine.clusters;
    });
    if (cancel.cancelled()) return;
    std::vector<VisibleCluster> clusters;
    uint64_t bytes = 0;
    for (size_t i = 0; i < of_tile.size(); ++i) {
        clusters.insert(clusters.end(), of_tile[i].begin(), of_tile[i].end());
        bytes += state.tiles[i].blocks.capacity() * sizeof(PointBlock) +
                 state.tiles[i].general.capacity() * sizeof(VisiblePoint);
    }
    parallel_for(clusters.size(), 64, [&](size_t i) {
        VisibleCluster& cluster = clusters[i];
        const vec3 normal = state.tiles[cluster.tile].blocks[cluster.first_block].geometric_normal.get(0);
        cluster.splat_radius_m = state.sizes.splats.radius_m(cluster.target.centre, normal);
    });
    state.clusters.build(std::move(clusters), state.eye.scene.bounds);
    state.record("visible_points", bytes + state.clusters.bytes());

    const EyeSeconds cpu = take_work(state.threads, stats);
    add_interleaved_stages(stats, wall_now_seconds() - wall_start,
                           {{"g_buffer", cpu.camera + cpu.points}, {"direct", cpu.direct}, {"indirect", cpu.indirect}});
}

/// Photons, and what they bring to the visible points.
void PhotonSplatting::splat_photons(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    if (!state.tracer) return;
    {
        const StageTimer timer(stats, "photon_tracing");
        state.photons = state.tracer->trace_reflected(state.eye.seed, pass, cancel);
    }
    stats.counts += state.photons.counts;
    if (cancel.cancelled()) return;
    const uint64_t bytes = state.photons.photons.size() * sizeof(ReflectedPhoton) +
                           state.photons.surfaces.size() * sizeof(ReflectingSurface);
    state.record("photons", bytes);
    state.sources.clear();
    if (params_.stratify) {
        const StageTimer timer(stats, "stratify");
        uint64_t peak_bytes = 0;
        state.sources = stratify(state.photons.photons,
                                 {.bounds = state.eye.scene.bounds,
                                  .cells = params_.grid_cells,
                                  .minimum_photons = params_.minimum_photons,
                                  .splats_per_cell = params_.splats_per_cell,
                                  .representative = params_.representative,
                                  .mean_power = state.settings.normalised},
                                 state.eye.seed, pass, peak_bytes);
        state.record("stratification", peak_bytes + state.sources.capacity() * sizeof(SplatSource));
        if (state.sources.empty()) return;
    }

    const SplatPass splat_pass{state.eye.scene,
                               state.eye.intersector,
                               state.settings,
                               state.sizes.beams,
                               params_,
                               state.shafts ? &*state.shafts : nullptr,
                               state.photons,
                               state.sources,
                               state.clusters,
                               state.eye.seed,
                               pass};
    const size_t count = splat_pass.source_count();
    const size_t at_once = SplatBatch::sources(params_.rays_per_photon);
    for (size_t first = 0; first < count && !cancel.cancelled(); first += at_once) {
        state.batch.make(splat_pass, first, std::min(first + at_once, count), stats, cancel);
        const StageTimer timer(stats, "splat");
        parallel_for(state.clusters.clusters().size(), 4, [&](size_t cluster) {
            if (cancel.cancelled()) return;
            State::PerThread& mine = state.threads.local();
            const auto index = static_cast<uint32_t>(cluster);
            mine.accumulator.light(splat_pass, state.batch, index, state.tiles[state.clusters.clusters()[cluster].tile],
                                   mine.counts);
        });
    }
    state.record("splat_batch", state.batch.bytes());
    for (State::PerThread& thread : state.threads) stats.counts += std::exchange(thread.counts, {});
}

/// Repays the clamp, and brings the points' sums into the image.
void PhotonSplatting::light_image(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    if (params_.connects() && params_.repay && state.tracer) {
        const StageTimer timer(stats, "repay");
        const PassSampler sampler(state.eye.sampler, state.eye.seed, RandomDomain::Splats, pass);
        const RepaymentScene shared{state.eye, params_.photon_threshold()};
        parallel_for(state.clusters.clusters().size(), 4, [&](size_t index) {
            if (cancel.cancelled()) return;
            State::PerThread& mine = state.threads.local();
            const VisibleCluster& cluster = state.clusters.clusters()[index];
            if (state.nothing_near(cluster)) return;
            PointTile& points = state.tiles[cluster.tile];
            mine.clamped.clear();
            for (uint32_t i = 0; i < cluster.points; ++i) {
                const PointBlock& block = points.blocks[cluster.first_block + i / kLanes];
                const size_t lane = i % kLanes;
                mine.clamped.push_back({block.position.get(lane), block.geometric_normal.get(lane),
                                        block.normal.get(lane),
                                        cluster.general ? &points.general[block.general[lane]] : nullptr,
                                        block.pixel[lane], cluster.most_scatterings});
            }
            mine.repaid.assign(cluster.points, Rgb(0));
            mine.repayment.repay(shared, sampler, mine.clamped, cluster.clamp_sq_m2(),
                                 {.clamped = mine.repaid, .narrow = {}}, mine.counts);
            for (uint32_t i = 0; i < cluster.points; ++i) {
                Vec3Array& sum = points.blocks[cluster.first_block + i / kLanes].sum;
                sum.set(i % kLanes, sum.get(i % kLanes) + mine.repaid[i]);
            }
        });
        for (State::PerThread& thread : state.threads) stats.counts += std::exchange(thread.counts, {});
    }

    const StageTimer timer(stats, state.settings.normalised ? "normalise" : "combine");
    const bool edges = params_.blur_edges && params_.blur != BlurWidth::None;
    if (edges) {
        state.blur_normal.assign(state.eye.view.film_size.pixels(), vec3(0));
        state.blur_depth.assign(state.eye.view.film_size.pixels(), kInfinity);
    }
    const std::span<const VisibleCluster> clusters = state.clusters.clusters();
    std::vector<std::vector<uint32_t>> of_tile(state.tiles.size());
    for (uint32_t i = 0; i < clusters.size(); ++i) of_tile[clusters[i].tile].push_back(i);
    const Camera& camera = state.eye.view.camera;
    parallel_for(state.tiles.size(), 1, [&](size_t tile) {
        for (const uint32_t index : of_tile[tile]) {
            const VisibleCluster& cluster = clusters[index];
            for (uint32_t i = 0; i < cluster.points; ++i) {
                const PointBlock& block = state.tiles[tile].blocks[cluster.first_block + i / kLanes];
                const size_t lane = i % kLanes;
                const uint32_t pixel = block.pixel[lane];
                Rgb light = block.sum.get(lane);
                if (state.settings.normalised)
                    light = block.splat_weight[lane] > 0
                                ? light * (params_.indirect_exposure / block.splat_weight[lane])
                                : Rgb(0);
                const Rgb weight = block.weight.get(lane);
                if (params_.ambient > 0 && block.splats[lane] == 0) {
                    const Rgb reflected =
                        cluster.general ? state.tiles[tile].general[block.general[lane]].rough.albedo() : Rgb(kPi);
                    light += params_.ambient * reflected;
                }
                state.image.of<Layer::Indirect>()[pixel] += weight * light;
                if (state.image.layers.has(Layer::Overlap))
                    state.image.of<Layer::Overlap>()[pixel] += block.splats[lane];
                if (edges) {
                    state.blur_normal[pixel] = block.normal.get(lane);
                    state.blur_depth[pixel] = glm::dot(block.position.get(lane) - camera.position, camera.forward);
                }
            }
        }
    });
}

void PhotonSplatting::blur(Stats& stats) {
    State& state = *state_;
    if (params_.blur == BlurWidth::None) return;
    const StageTimer timer(stats, "filter");
    BlurEdges edges;
    if (params_.blur_edges) edges.normal = state.blur_normal, edges.depth = state.blur_depth;
    blur_layer(state.image.of<Layer::Indirect>(), state.image.size, blur_pixels(params_.blur), edges);
}

PassImage* PhotonSplatting::end_pass() { return state_->pass_complete ? &state_->image : nullptr; }

}  // namespace photond
