#include "renderer/methods/photon_splatting/photon_splatting_gpu.h"

#include "renderer/backends/gpu/device_scene.h"
#include "renderer/eye/eye_constants.h"
#include "renderer/frame/device_frame.h"
#include "renderer/gbuffer/indirect_blur.h"
#include "renderer/methods/photon_splatting/splat_depth_atlas.h"
#include "renderer/methods/photon_splatting/splat_pilot.h"
#include "renderer/methods/photon_splatting/splat_settings.h"
#include "renderer/methods/photon_splatting/splat_shared.h"
#include "renderer/methods/photon_splatting/splat_volumes.h"
#include "renderer/methods/photon_splatting/stratification_gpu.h"
#include "renderer/photons/reflected_photons_gpu.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

namespace {

static_assert(kEyeTilePixels == SPLAT_GROUP);
constexpr uint32_t kBatchSplats = 1u << 16;
constexpr uint64_t kDepthBytes = 256ull << 20;  // of one batch's depth maps

std::string splatting_shader(const char* name) { return "renderer/methods/photon_splatting/" + std::string(name); }

/// Points of a pixel, and clusters of a tile, that room is made for at first: one where no path goes on past its first
/// point.
constexpr double kSpecularPoints = 1.3, kSpecularClusters = 3;
bool one_point_a_pixel(const Needs& needs) { return !needs.delta && !needs.glossy; }
uint32_t expected_points(Size2 size, const Needs& needs) {
    const auto all = static_cast<double>(eye_tile_count(size)) * kEyeTilePixels;
    return static_cast<uint32_t>(all * (one_point_a_pixel(needs) ? 1 : kSpecularPoints));
}
uint32_t expected_clusters(Size2 size, const Needs& needs) {
    return static_cast<uint32_t>(eye_tile_count(size) * (one_point_a_pixel(needs) ? 1 : kSpecularClusters));
}

/// Whether some photons light along their rays.
bool has_beams(const PhotonSplattingParams& params, const Needs& needs) {
    return !params.connects() || !needs.only_lambert();
}

uint64_t texels_of_splat(const PhotonSplattingParams& params, const Needs& needs) {
    return params.visibility && has_beams(params, needs) ? uint64_t{params.shadow_resolution} * params.shadow_resolution
                                                         : 0;
}

bool draws_depth_maps(const PhotonSplattingParams& params, const Needs& needs, uint64_t triangles) {
    return texels_of_splat(params, needs) > 0 && SplatDepthAtlas::faster(needs, triangles, params.shadow_resolution);
}

bool has_edges(const PhotonSplattingParams& params) { return params.blur_edges && params.blur != BlurWidth::None; }

/// Splats of a batch: a whole number of photons'.
uint32_t batch_splats(const PhotonSplattingParams& params, const Needs& needs) {
    // Light paths leave fewer than two photons each in most scenes, however many bounces they may have.
    const uint64_t all = params.bounces == 0 ? 0 : uint64_t{params.photons} * 2 * params.rays_per_photon;
    uint64_t splats = std::min<uint64_t>(all, kBatchSplats);
    if (const uint64_t texels = texels_of_splat(params, needs); texels > 0)
        splats = std::min(splats, kDepthBytes / (texels * sizeof(float)));
    const uint64_t photons = std::max<uint64_t>(splats / params.rays_per_photon, 1);
    return static_cast<uint32_t>(photons * params.rays_per_photon);
}

PhotonTracing tracing_of(const PhotonSplattingParams& params) {
    return {.photons = params.photons,
            .most_scatterings = params.bounces,
            .glossy_threshold = params.photon_threshold(),
            .sampler = params.sampler,
            .injection = params.injection,
            .rough_apart = params.connects()};
}

}  // namespace

struct PhotonSplattingGpu::State {
    State(const RenderContext& context, const PhotonSplattingParams& p, Beams beams)
        : params(p),
          device(context.device_scene->device()),
          device_scene(*context.device_scene),
          scene(context.scene),
          size(context.view.film_size),
          seed(context.seed),
          settings(p, context.scene),
          splats_at_once(batch_splats(p, context.scene.needs)),
          eye(device, "eye", sizeof(gpu::EyeConstants)),
          sampler(device, "sampler", sizeof(gpu::PassSamplerData)),
          repay_sampler(device, "sampler", sizeof(gpu::PassSamplerData)),
          constants(device, "splat_constants", sizeof(gpu::SplatConstants)),
          size_factors(device, "splat_sizes", sizeof(float)),
          beam_cells(device, "splat_sizes", sizeof(gpu::BeamCell)),
          beam_casters(device, "splat_sizes", sizeof(float)),
          counts(device, "visible_points", SPLAT_COUNTS * sizeof(uint32_t)),
          host_counts(device, "readback", SPLAT_COUNTS * sizeof(uint32_t), gpu::MemoryKind::Readback),
          heads(device, "visible_points", size.pixels() * sizeof(uint32_t)),
          edges(device, "blur_edges", (has_edges(p) ? size.pixels() : 1) * sizeof(vec4)),
          host_edges(device, "readback", edges.bytes(), gpu::MemoryKind::Readback),
          frame(context, [this](uint32_t pass, DeviceFrame::Steps& steps) { add_eye_steps(pass, steps); }) {
        const gpu::EyeConstants of_eye = make_eye_constants(context.view, p.max_scatterings(), ROULETTE_START);
        gpu::upload(device, eye, std::as_bytes(std::span(&of_eye, 1)));
        make_room(expected_points(size, scene.needs), expected_clusters(size, scene.needs));
        std::vector<gpu::Specialization> fixed;
        fixed.push_back(gpu::specialize(SPLAT_HAS_CONNECTIONS_ID, settings.connects));
        fixed.push_back(gpu::specialize(SPLAT_HAS_BEAMS_ID, has_beams(p, scene.needs)));
        fixed.push_back(gpu::specialize(SPLAT_NORMALISED_ID, settings.normalised));
        fixed.push_back(gpu::specialize(SPLAT_VISIBILITY_ID, settings.visibility));
        fixed.push_back(gpu::specialize(SPLAT_STRATIFIED_ID, p.stratify));
        fixed.push_back(gpu::specialize(SPLAT_EDGES_ID, has_edges(p)));
        fixed = device_scene.specialization(fixed);
        const auto pipeline = [&](const char* name, size_t push_bytes, bool reads_scene) {
            return std::make_unique<gpu::ComputePipeline>(device, splatting_shader(name),
                                                          static_cast<uint32_t>(push_bytes),
                                                          reads_scene ? &device_scene.set() : nullptr, fixed);
        };
        walk = pipeline("splat_eye.comp", sizeof(gpu::SplatEyePush), true);
        bound = pipeline("splat_clusters.comp", sizeof(gpu::SplatClusterPush), false);
        make = pipeline("splat_make.comp", sizeof(gpu::SplatMakePush), true);
        if (texels_of_splat(p, scene.needs) > 0 && !draws_depth_maps(p, scene.needs, scene.triangle_count))
            depth = pipeline("splat_depth.comp", sizeof(gpu::SplatClusterPush), true);
        if (settings.connects && p.repay) repay = pipeline("splat_repay.comp", sizeof(gpu::SplatPointPush), true);
        combine = pipeline("splat_combine.comp", sizeof(uint32_t), true);
        if (beams == Beams::Volumes && !settings.connects && SplatVolumes::possible(scene.needs, context.view.camera))
            volumes.emplace(device_scene, size, fixed);
        else
            light = pipeline("splat_light.comp", sizeof(gpu::SplatClusterPush), true);
    }

    void make_room(uint32_t points_wanted, uint32_t clusters_wanted) {
        if (points_wanted > point_capacity) {
            points = {}, sums = {}, general_points = {};
            point_capacity = points_wanted;
            points = gpu::Buffer(device, "visible_points", uint64_t{points_wanted} * sizeof(gpu::SplatPoint));
            sums = gpu::Buffer(device, "visible_points", uint64_t{points_wanted} * sizeof(gpu::SplatSum));
            const uint64_t general = scene.needs.only_lambert() ? 1 : points_wanted;
            general_points = gpu::Buffer(device, "visible_points", general * sizeof(gpu::GBufferGeneral));
        }
        if (clusters_wanted > cluster_capacity) {
            clusters = {};
            cluster_capacity = clusters_wanted;
            clusters = gpu::Buffer(device, "visible_points", uint64_t{clusters_wanted} * sizeof(gpu::SplatCluster));
        }
    }

    uint32_t counted(uint32_t word) const { return host_counts.as<uint32_t>()[word]; }
    gpu::SplatConstants constants_of(uint32_t pass) const;

    /// True where the pass found more points or photons than there was room for: now there is.
    bool grow_if_short() {
        const uint32_t found_points = counted(SPLAT_COUNT_POINTS), found_clusters = counted(SPLAT_COUNT_CLUSTERS);
        const bool short_of_points = found_points > point_capacity || found_clusters > cluster_capacity;
        if (short_of_points) make_room(found_points + found_points / 8, found_clusters + found_clusters / 8);
        const bool short_of_photons = photons && photons->grow_if_short();
        return short_of_points || short_of_photons;
    }

    void add_eye_steps(uint32_t pass, DeviceFrame::Steps& steps);
    std::vector<PieceQueue::Record> photon_pieces(uint32_t pass);
    bool stratify(uint32_t pass, Stats& stats, const CancelToken& cancel);
    std::vector<PieceQueue::Record> splat_pieces();
    std::vector<PieceQueue::Record> image_pieces();
    SplatVolumes::Points volume_points() { return {eye, constants, heads, points, sums, device_image.counters()}; }
    void blur(Stats& stats);
    void add_batch(uint32_t first_photon, uint32_t end_photon, std::vector<PieceQueue::Record>& pieces);

    const PhotonSplattingParams& params;
    gpu::Device& device;
    const gpu::DeviceScene& device_scene;
    const Scene& scene;
    const Size2 size;
    const uint64_t seed;
    const SplatSettings settings;
    const uint32_t splats_at_once;
    uint32_t point_capacity = 0, cluster_capacity = 0;
    PilotSizes sizes{SplatSizes(settings.radius_m), BeamSizes(settings.beam_radius_m)};

    gpu::Buffer eye, sampler, repay_sampler, constants, size_factors, beam_cells, beam_casters, counts, host_counts,
        heads, edges, host_edges;
    gpu::Buffer points, general_points, sums, clusters, splats, depth_maps;
    std::unique_ptr<gpu::ComputePipeline> walk, bound, make, depth, light, repay, combine;
    std::optional<EmissionSampler> emission;
    std::optional<ReflectedPhotonsGpu> photons;
    std::optional<StratificationGpu> stratification;
    std::optional<SplatVolumes> volumes;         // null: splats are gone through cluster by cluster
    std::optional<SplatDepthAtlas> depth_atlas;  // null: depth maps are traced
    DeviceFrame frame;                           // last: its going waits for work that uses the others
    DeviceImage& device_image = frame.image();
};

gpu::SplatConstants PhotonSplattingGpu::State::constants_of(uint32_t pass) const {
    gpu::SplatConstants of_pass{};
    of_pass.seed = seed;
    of_pass.pass = pass;
    of_pass.shrink = settings.shrink(pass);
    of_pass.kernel = settings.filter.device_record();
    of_pass.radius_m = settings.radius_m;
    of_pass.beam_radius_m = settings.beam_radius_m;
    of_pass.beam_step_back_m = settings.step_back_m;
    of_pass.beam_step_back_radii = settings.step_back_radii;
    of_pass.beam_depth_m = settings.depth_m;
    of_pass.beam_depth_radii = settings.depth_radii;
    of_pass.beam_levels = sizes.beams.levels();
    of_pass.beam_casters = static_cast<uint32_t>(sizes.beams.casters().size());
    of_pass.shadow_resolution = settings.shadow_resolution;
    of_pass.rays_per_photon = params.rays_per_photon;
    of_pass.connects = settings.connects;
    of_pass.glossy_threshold = params.glossy_threshold;
    of_pass.photon_threshold = params.photon_threshold();
    of_pass.colour_scale = static_cast<float>(params.photons) / settings.surface_area_m2;
    of_pass.exposure = params.indirect_exposure;
    of_pass.ambient = params.ambient;
    of_pass.point_capacity = point_capacity;
    of_pass.cluster_capacity = cluster_capacity;
    if (const auto grid = sizes.splats.grid()) {
        of_pass.sizes_low = grid->low;
        of_pass.sizes_cell_m = grid->cell_m;
        of_pass.sizes_cells = grid->cells;
    }
    return of_pass;
}

/// Direct light and the visible points.
void PhotonSplattingGpu::State::add_eye_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    const uint32_t tiles = eye_tile_count(size), at_once = std::max(device.paths_per_submit() / kEyeTilePixels, 1u);
    for (uint32_t first = 0; first < tiles; first += at_once) {
        const uint32_t end = std::min(first + at_once, tiles);
        const auto record = [=, this](gpu::CommandList& commands) {
            if (first == 0) {
                commands.fill(counts, 0);
                const auto numbers = [&](RandomDomain domain) {
                    return PassSampler(params.sampler, seed, domain, pass).device_data();
                };
                commands.update(sampler, numbers(RandomDomain::Camera));
                commands.update(repay_sampler, numbers(RandomDomain::Splats));
                commands.update(constants, constants_of(pass));
            }
            {
                const gpu::Scope scope(commands, "direct");
                commands.bind(*walk,
                              {gpu::read_write("device_layers", device_image.layers()),
                               gpu::read_write("device_counters", device_image.counters()), gpu::read("eye", eye),
                               gpu::read("pass_sampler", sampler), gpu::read("constants", constants),
                               gpu::read_write("counts", counts), gpu::write("first_of_pixel", heads),
                               gpu::write("points", points), gpu::write("general_points", general_points),
                               gpu::write("sums", sums), gpu::write("clusters", clusters)});
                commands.push(gpu::SplatEyePush{first, end});
                commands.dispatch_threads(uint64_t{end - first} * kEyeTilePixels, kEyeTilePixels);
            }
            if (end < tiles) return;
            const gpu::Scope scope(commands, "g_buffer");
            commands.bind(*bound, {gpu::read("constants", constants), gpu::read("counts", counts),
                                   gpu::read("size_factors", size_factors), gpu::read_write("points", points),
                                   gpu::read_write("clusters", clusters)});
            commands.push(gpu::SplatClusterPush{0, cluster_capacity, 0, 0});
            commands.dispatch_threads(uint64_t{cluster_capacity} * SPLAT_GROUP, SPLAT_GROUP);
            commands.copy(counts, 0, host_counts, 0, host_counts.bytes());
            commands.host_reads(host_counts);
        };
        steps.push_back({uint64_t{end - first} * kEyeTilePixels, record});
    }
}

std::vector<PieceQueue::Record> PhotonSplattingGpu::State::photon_pieces(uint32_t pass) {
    const uint32_t paths = photons->start(seed, pass), at_once = device.paths_per_submit();
    std::vector<PieceQueue::Record> pieces;
    for (uint32_t first = 0; first < paths; first += std::min(at_once, paths - first)) {
        pieces.push_back([=, this, end = first + std::min(at_once, paths - first)](gpu::CommandList& commands) {
            if (first == 0) photons->record_start(commands);
            photons->record_paths(commands, first, end);
            if (end == paths) photons->record_order(commands);
        });
    }
    return pieces;
}

/// Which photons splat. False: cancelled.
bool PhotonSplattingGpu::State::stratify(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    if (!stratification) return true;
    const StageTimer timer(stats, "stratify");
    stratification->start(seed, pass, photons->photons_of_pass());
    return frame.run_more({[this](gpu::CommandList& commands) {
                              stratification->record(commands, photons->photons(), photons->order());
                          }},
                          stats, cancel);
}

/// What the photons bring to the visible points, batch after batch.
std::vector<PieceQueue::Record> PhotonSplattingGpu::State::splat_pieces() {
    const uint32_t sources = stratification ? stratification->sources_of_pass() : photons->photons_of_pass();
    const uint32_t at_once = splats_at_once / params.rays_per_photon;
    std::vector<PieceQueue::Record> pieces;
    for (uint32_t first = 0; first < sources; first += std::min(at_once, sources - first))
        add_batch(first, first + std::min(at_once, sources - first), pieces);
    if (volumes && sources > 0) {
        pieces.push_back([this](gpu::CommandList& commands) {
            const gpu::Scope scope(commands, "splat");
            volumes->record_sums(commands, volume_points());
        });
    }
    return pieces;
}

void PhotonSplattingGpu::State::add_batch(uint32_t first_photon, uint32_t end_photon,
                                          std::vector<PieceQueue::Record>& pieces) {
    const uint32_t count = (end_photon - first_photon) * params.rays_per_photon;
    pieces.push_back([=, this](gpu::CommandList& commands) {
        const gpu::Scope scope(commands, "splat_depth");
        commands.bind(*make, {gpu::read_write("device_counters", device_image.counters()),
                              gpu::read("constants", constants), gpu::read("state", photons->state()),
                              gpu::read("photons", photons->photons()), gpu::read("order", photons->order()),
                              gpu::read("surfaces", photons->surfaces()), gpu::write("splats", splats),
                              gpu::read("sources", stratification ? stratification->sources() : counts),
                              gpu::read("beam_cells", beam_cells), gpu::read("beam_casters_m", beam_casters)});
        commands.push(gpu::SplatMakePush{first_photon, end_photon, count});
        commands.dispatch_threads(count, SPLAT_GROUP);
    });
    if (const uint64_t texels = texels_of_splat(params, scene.needs); texels > 0) {
        const uint32_t maps = depth_atlas
                                  ? depth_atlas->splats_at_once()
                                  : static_cast<uint32_t>(std::max<uint64_t>(device.paths_per_submit() / texels, 1));
        for (uint32_t first = 0; first < count; first += std::min(maps, count - first)) {
            pieces.push_back([=, this, end = first + std::min(maps, count - first)](gpu::CommandList& commands) {
                const gpu::Scope scope(commands, "splat_depth");
                if (depth_atlas) return depth_atlas->record(commands, constants, splats, depth_maps, first, end);
                commands.bind(*depth, {gpu::read_write("device_counters", device_image.counters()),
                                       gpu::read("constants", constants), gpu::read("splats", splats),
                                       gpu::write("farthest_m", depth_maps)});
                commands.push(gpu::SplatClusterPush{0, 0, first, end});
                commands.dispatch_threads(uint64_t{end - first} * SPLAT_GROUP, SPLAT_GROUP);
            });
        }
    }
    if (volumes) {
        const uint32_t volumes_at_once = volumes->splats_at_once();
        for (uint32_t first = 0; first < count; first += std::min(volumes_at_once, count - first)) {
            pieces.push_back([=, this, end = first + std::min(volumes_at_once, count - first),
                              clear = first_photon == 0 && first == 0](gpu::CommandList& commands) {
                const gpu::Scope scope(commands, "splat");
                volumes->record(commands, volume_points(), splats, depth_maps, first, end, clear);
            });
        }
        return;
    }
    // Pairs of a cluster and a splat. All clusters together, as far as may be: the more groups, the fuller the device.
    const uint32_t clusters_in_all = counted(SPLAT_COUNT_CLUSTERS), pairs = device.paths_per_submit();
    const uint32_t clusters_at_once = std::min(clusters_in_all, pairs / SPLAT_GROUP);
    const uint32_t splats_a_piece = std::max(pairs / std::max(clusters_at_once, 1u) / SPLAT_GROUP, 1u) * SPLAT_GROUP;
    for (uint32_t cluster = 0; cluster < clusters_in_all; cluster += clusters_at_once) {
        for (uint32_t first = 0; first < count; first += std::min(splats_a_piece, count - first)) {
            const gpu::SplatClusterPush push{cluster, std::min(cluster + clusters_at_once, clusters_in_all), first,
                                             first + std::min(splats_a_piece, count - first)};
            pieces.push_back([push, this](gpu::CommandList& commands) {
                const gpu::Scope scope(commands, "splat");
                commands.bind(*light, {gpu::read_write("device_counters", device_image.counters()),
                                       gpu::read("constants", constants), gpu::read("counts", counts),
                                       gpu::read("clusters", clusters), gpu::read("points", points),
                                       gpu::read("general_points", general_points), gpu::read("splats", splats),
                                       gpu::read("farthest_m", depth_maps), gpu::read("surfaces", photons->surfaces()),
                                       gpu::read_write("sums", sums)});
                commands.push(push);
                commands.dispatch_threads(uint64_t{push.end_cluster - push.first_cluster} * SPLAT_GROUP, SPLAT_GROUP);
            });
        }
    }
}

/// Repays the clamp, brings the points' sums into the image, and the image to the host.
std::vector<PieceQueue::Record> PhotonSplattingGpu::State::image_pieces() {
    std::vector<PieceQueue::Record> pieces;
    if (settings.connects && params.repay && photons) {
        const uint32_t all = counted(SPLAT_COUNT_POINTS), at_once = device.paths_per_submit();
        for (uint32_t first = 0; first < all; first += std::min(at_once, all - first)) {
            pieces.push_back([=, this, end = first + std::min(at_once, all - first)](gpu::CommandList& commands) {
                const gpu::Scope scope(commands, "repay");
                commands.bind(*repay, {gpu::read_write("device_layers", device_image.layers()),
                                       gpu::read_write("device_counters", device_image.counters()),
                                       gpu::read("eye", eye), gpu::read("pass_sampler", repay_sampler),
                                       gpu::read("constants", constants), gpu::read("points", points),
                                       gpu::read("general_points", general_points), gpu::read_write("sums", sums)});
                commands.push(gpu::SplatPointPush{first, end});
                commands.dispatch_threads(end - first, SPLAT_GROUP);
            });
        }
    }
    pieces.push_back([this](gpu::CommandList& commands) {
        {
            const gpu::Scope scope(commands, settings.normalised ? "normalise" : "combine");
            commands.bind(*combine, {gpu::read_write("device_layers", device_image.layers()),
                                     gpu::read("constants", constants), gpu::read("first_of_pixel", heads),
                                     gpu::read("points", points), gpu::read("general_points", general_points),
                                     gpu::read("sums", sums), gpu::read("eye", eye), gpu::write("edges", edges)});
            commands.push(static_cast<uint32_t>(size.pixels()));
            commands.dispatch_threads(size.pixels(), SPLAT_GROUP);
        }
        if (has_edges(params)) {
            commands.copy(edges, 0, host_edges, 0, edges.bytes());
            commands.host_reads(host_edges);
        }
        device_image.record_readback(commands);
    });
    return pieces;
}

/// Of the host's image: it is done before the next pass's paths are.
void PhotonSplattingGpu::State::blur(Stats& stats) {
    if (params.blur == BlurWidth::None) return;
    const StageTimer timer(stats, "filter");
    std::vector<vec3> normal;
    std::vector<float> depth;
    if (has_edges(params)) {
        for (const vec4& edge : host_edges.as<vec4>()) {
            normal.emplace_back(edge);
            depth.push_back(edge.w);
        }
    }
    blur_layer(frame.host_image().of<Layer::Indirect>(), size, blur_pixels(params.blur),
               {.normal = normal, .depth = depth});
}

PhotonSplattingGpu::PhotonSplattingGpu(const PhotonSplattingParams& params, Beams beams)
    : params_(params), beams_(beams) {}
PhotonSplattingGpu::~PhotonSplattingGpu() = default;

uint64_t PhotonSplattingGpu::estimate_bytes(const PhotonSplattingParams& params, const Workload& workload) {
    return DeviceFrame::estimate_bytes(workload) +
           (has_edges(params) ? workload.film_size.pixels() * (sizeof(vec3) + sizeof(float)) : 0) +
           (params.bounces > 0 ? EmissionSampler::estimate_bytes(workload.lights, workload.environment_size) : 0);
}

uint64_t PhotonSplattingGpu::estimate_device_bytes(const PhotonSplattingParams& params, const Workload& workload) {
    const bool lambert = workload.needs.only_lambert();
    const uint64_t of_point =
        sizeof(gpu::SplatPoint) + sizeof(gpu::SplatSum) + (lambert ? 0 : sizeof(gpu::GBufferGeneral));
    uint64_t bytes = DeviceFrame::estimate_device_bytes(workload) + workload.film_size.pixels() * sizeof(uint32_t) +
                     expected_points(workload.film_size, workload.needs) * of_point +
                     expected_clusters(workload.film_size, workload.needs) * sizeof(gpu::SplatCluster) +
                     (has_edges(params) ? 2 * workload.film_size.pixels() * sizeof(vec4) : 0) +
                     sizeof(gpu::EyeConstants) + 2 * sizeof(gpu::PassSamplerData) + sizeof(gpu::SplatConstants);
    if ((workload.lights == 0 && workload.environment_size.pixels() == 0) || params.bounces == 0) return bytes;
    const uint64_t texels = texels_of_splat(params, workload.needs);
    if (params.stratify)
        bytes += StratificationGpu::device_bytes(ReflectedPhotonsGpu::expected_photons(tracing_of(params)),
                                                 params.minimum_photons);
    if (draws_depth_maps(params, workload.needs, workload.triangles))
        bytes += SplatDepthAtlas::device_bytes(params.shadow_resolution, batch_splats(params, workload.needs));
    return bytes + ReflectedPhotonsGpu::device_bytes(tracing_of(params), lambert) +
           batch_splats(params, workload.needs) * (sizeof(gpu::Splat) + texels * sizeof(float));
}

void PhotonSplattingGpu::begin(const RenderContext& context, Stats& stats) {
    const Scene& scene = context.scene;
    {
        const StageTimer timer(stats, "pipelines");
        state_ = std::make_unique<State>(context, params_, beams_);
    }
    State& state = *state_;

    const char* nothing = params_.bounces == 0 ? "bounces is 0" : nullptr;
    if (!nothing) {
        const StageTimer timer(stats, "photon_emission");
        state.emission.emplace(scene);
        if (!(state.emission->total_power_w() > 0)) {
            state.emission.reset();
            nothing = "the scene has no light";
        }
    }
    if (nothing) {
        stats.skipped.push_back(
            {"splats", nothing, ReflectedPhotonsGpu::device_bytes(tracing_of(params_), scene.needs.only_lambert())});
        return;
    }
    context.budget.record("emission_sampler", state.emission->bytes());
    const PhotonTracing tracing = tracing_of(params_);
    state.photons.emplace(state.device_scene, *state.emission, tracing, state.device_image.counters());
    const uint64_t splats = state.splats_at_once;
    state.splats = gpu::Buffer(state.device, "splats", splats * sizeof(gpu::Splat));
    state.depth_maps =
        gpu::Buffer(state.device, "depth_maps",
                    std::max<uint64_t>(splats * texels_of_splat(params_, scene.needs), 1) * sizeof(float));
    if (params_.stratify) {
        state.stratification.emplace(state.device, StratificationSettings{.bounds = scene.bounds,
                                                                          .cells = params_.grid_cells,
                                                                          .minimum_photons = params_.minimum_photons,
                                                                          .splats_per_cell = params_.splats_per_cell,
                                                                          .representative = params_.representative,
                                                                          .mean_power = state.settings.normalised});
    }
    if (draws_depth_maps(params_, scene.needs, scene.triangle_count))
        state.depth_atlas.emplace(state.device_scene, params_.shadow_resolution, state.splats_at_once);
    {
        const StageTimer timer(stats, "photon_tracing");
        state.sizes = sizes_by_pilot(state.settings, params_, scene, *context.intersector, *state.emission, tracing,
                                     context.seed, stats);
        const auto upload = [&](gpu::Buffer& buffer, const auto& values) {
            if (values.empty()) return;
            buffer = {};
            buffer = gpu::make_buffer(state.device, "splat_sizes", values);
        };
        if (const auto grid = state.sizes.splats.grid()) upload(state.size_factors, grid->factors);
        upload(state.beam_cells, state.sizes.beams.cells());
        upload(state.beam_casters, state.sizes.beams.casters());
    }
    if (!has_beams(params_, scene.needs))
        stats.skipped.push_back({"depth maps of beams", "no surface reflects but by its rough part", 0});
    note_skipped_shading(scene.needs, stats);
}

/// Visible points, direct light and photons. False: cancelled.
bool PhotonSplattingGpu::look_and_trace(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    {
        const StageTimer timer(stats, "direct");
        if (!state.frame.run(pass, stats, cancel)) return false;
    }
    if (!state.photons) return true;
    const StageTimer timer(stats, "photon_tracing");
    return state.frame.run_more(state.photon_pieces(pass), stats, cancel);
}

void PhotonSplattingGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    do {
        if (!look_and_trace(pass, stats, cancel)) return;
    } while (state.grow_if_short());
    if (state.photons) {
        state.photons->add_to(stats.counts);
        const StageTimer timer(stats, "splat");
        if (!state.stratify(pass, stats, cancel)) return;
        if (!state.frame.run_more(state.splat_pieces(), stats, cancel)) return;
    }
    const StageTimer timer(stats, state.settings.normalised ? "normalise" : "combine");
    if (!state.frame.run_more(state.image_pieces(), stats, cancel)) return;
    state.frame.read(stats);
    state.blur(stats);
}

DeviceFrame& PhotonSplattingGpu::frame() { return state_->frame; }

}  // namespace photond
