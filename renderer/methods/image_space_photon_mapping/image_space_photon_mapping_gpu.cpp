#include "renderer/methods/image_space_photon_mapping/image_space_photon_mapping_gpu.h"

#include <array>
#include <list>
#include <numeric>

#include "renderer/core/thread_local.h"
#include "renderer/eye/eye_constants.h"
#include "renderer/frame/device_frame.h"
#include "renderer/gathering/expected_photons.h"
#include "renderer/gbuffer/gbuffer_gpu.h"
#include "renderer/methods/image_space_photon_mapping/photon_combine_shared.h"
#include "renderer/methods/image_space_photon_mapping/photon_raster.h"
#include "renderer/methods/image_space_photon_mapping/photon_scatter_shared.h"
#include "renderer/photons/caustic_photons.h"
#include "renderer/photons/edge_tree.h"
#include "renderer/photons/photon_guides.h"
#include "renderer/photons/photon_maps_gpu.h"
#include "renderer/photons/photons_ahead.h"
#include "renderer/photons/surface_edges.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

static_assert(uint32_t(SoftShadow::Gather) == SOFT_SHADOW_GATHER &&
              uint32_t(SoftShadow::FixedRadius) == SOFT_SHADOW_FIXED_RADIUS &&
              uint32_t(SoftShadow::Rays) == SOFT_SHADOW_RAYS && uint32_t(SoftShadow::None) == SOFT_SHADOW_NONE);

static_assert(uint32_t(PhotonFootprint::Quad) == FOOTPRINT_QUAD &&
              uint32_t(PhotonFootprint::Volume) == FOOTPRINT_VOLUME &&
              uint32_t(PhotonFootprint::Auto) == FOOTPRINT_AUTO);

constexpr std::array kScatteredKinds{PhotonMapKind::Global, PhotonMapKind::Caustic};
constexpr size_t map_of(PhotonMapKind kind) { return static_cast<size_t>(kind); }

uint32_t photons_of(const ImageSpacePhotonMappingParams& params, PhotonMapKind kind) {
    return kind == PhotonMapKind::Global ? params.photons : params.caustic_photons.value_or(params.photons);
}

/// Why a scene has no photons of that kind; null: it has.
const char* why_none(const ImageSpacePhotonMappingParams& params, PhotonMapKind kind, bool lights, bool specular) {
    if (params.bounces == 0u) return "bounces is 0";
    if (!lights) return "the scene has no light";
    if (kind == PhotonMapKind::Caustic && !specular) return "no surface is specular";
    return nullptr;
}

/// Of a scene before it is loaded.
bool may_have(const ImageSpacePhotonMappingParams& params, PhotonMapKind kind, const Workload& workload) {
    return why_none(params, kind, workload.lights > 0 || workload.environment_size.pixels() > 0,
                    workload.needs.delta || workload.needs.glossy) == nullptr;
}

/// What a map is laid out for, whatever it then stores: its order must be the same in each pass.
uint64_t expected_of(const ImageSpacePhotonMappingParams& params, PhotonMapKind kind) {
    return expected_photons(photons_of(params, kind), yield_of(kExpectedPhotonYield, kind).unguided);
}

uint32_t batches_for(uint64_t photons) { return static_cast<uint32_t>((photons + SCATTER_GROUP - 1) / SCATTER_GROUP); }

GBufferWalk walk_of(const ImageSpacePhotonMappingParams& params) {
    return {.split_side = params.subsampling,
            .max_scatterings = params.max_scatterings(),
            .glossy_threshold = params.glossy_threshold,
            .sampler = params.sampler};
}

constexpr uint64_t kBounceBytes = PHOTON_BOUNCES * sizeof(uint32_t);

/// A layer that shows the bounce map needs one.
uint32_t bounce_map_texels(const ImageSpacePhotonMappingParams& params, LayerSet layers) {
    if (params.traces_on_host()) return 0;
    return params.bounce_map_texels.value_or(layers.has(Layer::BounceMap) ? params.photons : 0);
}

/// Photons of a pass, where nobody has counted them.
double stored_by(const ImageSpacePhotonMappingParams& params, PhotonMapKind kind, const PhotonYield& yield) {
    return yield_of(yield, kind).by(params.projection_maps) * photons_of(params, kind);
}

std::unique_ptr<CentreShadowsGpu> make_centres(const ImageSpacePhotonMappingParams& params,
                                               const gpu::DeviceScene& scene, Size2 size) {
    if (!params.shadows_by_centres()) return nullptr;
    return std::make_unique<CentreShadowsGpu>(scene, size);
}

std::string scatter_shader(const char* name) {
    return "renderer/methods/image_space_photon_mapping/" + std::string(name);
}

}  // namespace

struct ImageSpacePhotonMappingGpu::State {
    // A step from the parts of the light to the image.
    struct CombineStep {
        CombineStep(gpu::Device& device, const char* name, std::span<const gpu::Specialization> fixed,
                    const gpu::BufferSet& scene)
            : stage(name),
              pipeline(device, scatter_shader("photon_combine.comp"), sizeof(gpu::ShadowSamples), &scene, fixed) {}
        const char* stage;
        gpu::ComputePipeline pipeline;
    };

    State(const RenderContext& context, const ImageSpacePhotonMappingParams& p)
        : params(p),
          on_device(*context.device_scene),
          device(on_device.device()),
          scene(context.scene),
          budget(context.budget),
          eye(make_eye_constants(context.view, 1, 1)),
          seed(context.seed),
          first_radius_m(p.radius_of_pass_m(0, context.scene.bounds.radius())),
          shows_bounces(context.view.layers.has(Layer::BounceMap)),
          texels(bounce_map_texels(p, context.view.layers)),
          maps(on_device),
          bounces(device, "photon_scatter", kBounceBytes),
          host_bounces(device, "readback", kBounceBytes, gpu::MemoryKind::Readback),
          constants(device, "photon_scatter", sizeof(gpu::PhotonScatterConstants)),
          frame(context, [this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); }),
          centres(make_centres(p, on_device, context.view.film_size)),
          points(on_device, context.view, seed, walk_of(p), frame.image(), {.centres = centres.get()}) {}
    ~State() { frame.end(); }

    void add_map(const RenderContext& context, PhotonMapKind kind);
    void add_counts(PhotonMapKind kind, Counts& counts) const;
    void make_room();
    void make_scatter_pipelines();
    void make_combine_pipelines();
    bool grow_if_short();
    gpu::PhotonScatterConstants constants_of(uint32_t pass);
    void add_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void add_scatter_steps(PhotonMapKind kind, DeviceFrame::Steps& steps);
    void add_raster_steps(PhotonMapKind kind, DeviceFrame::Steps& steps);
    void record_combining(gpu::CommandList& commands);
    void record_bounce_map_layer(gpu::CommandList& commands);
    uint32_t batches_of(PhotonMapKind kind) const { return batches_for(maps.room(map_of(kind))); }

    const ImageSpacePhotonMappingParams& params;
    const gpu::DeviceScene& on_device;
    gpu::Device& device;
    const Scene& scene;
    MemoryBudget& budget;
    const gpu::EyeConstants eye;
    const uint64_t seed;
    const float first_radius_m;
    const bool shows_bounces;  // as a layer
    std::optional<EmissionSampler> emission;
    std::optional<PhotonGuides> guides;
    std::optional<PhotonsAhead> ahead;  // null: the device traces
    const uint32_t texels;              // of the bounce map; 0: none
    std::optional<EdgeTree> edges;      // where footprints are cut
    PhotonMapsGpu maps;                 // by kind
    gpu::Buffer bounces, host_bounces;  // photons by scatterings
    gpu::Buffer constants, batches;
    std::array<uint32_t, kScatteredKinds.size()> first_batch{};
    std::optional<gpu::ComputePipeline> bound, scatter, show_bounces;
    std::optional<PhotonRaster> raster;  // null: tiles alone
    std::list<CombineStep> combine;
    DeviceFrame frame;
    const std::unique_ptr<CentreShadowsGpu> centres;  // null: shadows are rays'
    GBufferGpu points;
};

void ImageSpacePhotonMappingGpu::State::add_map(const RenderContext& context, PhotonMapKind kind) {
    const PhotonTracing tracing{.kind = kind,
                                .photons = photons_of(params, kind),
                                .most_scatterings = params.photon_scatterings(),
                                .glossy_threshold = params.glossy_threshold,
                                .sampler = params.sampler,
                                .guide = guides->of(kind)};
    if (!params.traces_on_host()) {
        maps.add(map_of(kind), tracing, expected_of(params, kind), kind == PhotonMapKind::Global ? texels : 0);
        return;
    }
    if (!ahead) ahead.emplace(seed);
    ahead->add(scene, *context.host_intersector, *emission, tracing);
    maps.add_traced_on_host(map_of(kind), expected_of(params, kind));
}

void ImageSpacePhotonMappingGpu::State::add_counts(PhotonMapKind kind, Counts& counts) const {
    if (ahead)
        counts += ahead->photons(kind).counts;
    else
        maps.add_to(counts, map_of(kind));
}

void ImageSpacePhotonMappingGpu::State::make_room() {
    // Edges lie behind the grids' own words: shaders may bind no more buffers.
    maps.make_room(edges ? edges->device_words() : std::vector<uint32_t>());
    uint32_t all = 0;
    for (const PhotonMapKind kind : kScatteredKinds) {
        if (!maps.has(map_of(kind))) continue;
        // Cells of the first radius, whatever the pass's: they only put photons in an order in which neighbours are
        // near.
        maps.cut_cells(map_of(kind), first_radius_m);
        first_batch[map_of(kind)] = all;
        all += batches_of(kind);
    }
    batches = {};
    batches = gpu::Buffer(device, "photon_scatter", std::max(all, 1u) * sizeof(gpu::PhotonBatch));
}

void ImageSpacePhotonMappingGpu::State::make_scatter_pipelines() {
    std::vector<gpu::Specialization> fixed = on_device.specialization(
        std::vector{gpu::specialize(FOOTPRINT_ID, static_cast<uint32_t>(params.footprint)),
                    gpu::specialize(DISC_COVERAGE_ID, edges.has_value()),
                    gpu::specialize(UPSAMPLING_ID, static_cast<uint32_t>(params.upsampling)),
                    gpu::specialize(SCATTER_DRAWS_ID, params.scatter == PhotonScatter::Raster)});
    bound.emplace(device, scatter_shader("photon_batches.comp"), sizeof(gpu::PhotonBatchPush));
    scatter.emplace(device, scatter_shader("photon_scatter.comp"), sizeof(gpu::PhotonScatterPush), &on_device.set(),
                    fixed);
    if (shows_bounces && maps.has(map_of(PhotonMapKind::Global)))
        show_bounces.emplace(device, scatter_shader("bounce_map_layer.comp"), sizeof(gpu::BounceMapLayerPush),
                             &on_device.set(), on_device.specialization());
    if (params.scatter == PhotonScatter::Raster) raster.emplace(on_device, points.layout(), params.footprint, fixed);
}

void ImageSpacePhotonMappingGpu::State::make_combine_pipelines() {
    const std::vector<gpu::Specialization> fixed = on_device.specialization(
        std::vector{gpu::specialize(UPSAMPLING_ID, static_cast<uint32_t>(params.upsampling)),
                    gpu::specialize(SOFT_SHADOW_ID, static_cast<uint32_t>(params.soft_shadow))});
    std::vector<std::pair<uint32_t, const char*>> steps;
    if (params.subsampling > 1) steps.emplace_back(COMBINE_UPSAMPLE, "upsample");
    if (centres) steps.emplace_back(COMBINE_SHADOW, "soft_shadows");
    steps.emplace_back(COMBINE_MERGE, "merge");
    if (params.one_pass && steps.size() > 1)
        steps = {{std::accumulate(steps.begin(), steps.end(), 0u,
                                  [](uint32_t all, const auto& step) { return all | step.first; }),
                  "combine"}};
    for (const auto& [parts, stage] : steps) {
        std::vector<gpu::Specialization> of_step = fixed;
        of_step.push_back(gpu::specialize(COMBINE_PARTS_ID, parts));
        combine.emplace_back(device, stage, of_step, on_device.set());
    }
}

bool ImageSpacePhotonMappingGpu::State::grow_if_short() {
    const bool is_short = maps.is_short();
    if (is_short) make_room();
    return is_short;
}

gpu::PhotonScatterConstants ImageSpacePhotonMappingGpu::State::constants_of(uint32_t pass) {
    gpu::PhotonScatterConstants of_pass{};
    for (const PhotonMapKind kind : kScatteredKinds) {
        const size_t map = map_of(kind);
        of_pass.maps[map] = maps.grid(map);
        of_pass.first_batch[map] = first_batch[map];
    }
    of_pass.radius_m = params.radius_of_pass_m(pass, scene.bounds.radius());
    of_pass.radius_of_map_m[map_of(PhotonMapKind::Global)] = of_pass.radius_m;
    of_pass.radius_of_map_m[map_of(PhotonMapKind::Caustic)] = params.caustic_radius_share * of_pass.radius_m;
    of_pass.volume_height = params.volume_height;
    of_pass.kernel = Kernel(params.kernel, params.cone_k).device_record();
    of_pass.split = points.split();
    if (edges) of_pass.coverage = edges->device_constants(maps.first_word());
    of_pass.turn = static_cast<uint32_t>(hash64(hash64(seed) + pass));
    of_pass.glossy_threshold = params.glossy_threshold;
    of_pass.filter_reach = eye.smooth_filter != 0 ? FILTER_RADIUS : 0.5f;
    of_pass.camera = eye.camera;
    return of_pass;
}

void ImageSpacePhotonMappingGpu::State::add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    for (uint32_t piece = 0; piece < points.pieces(); ++piece)
        steps.push_back({points.layout().size.pixels() / points.pieces(), [=, this](gpu::CommandList& commands) {
                             if (piece == 0) {
                                 commands.update(constants, constants_of(pass));
                                 commands.fill(bounces, 0);
                             }
                             points.record(commands, pass, piece);
                         }});
    for (const PhotonMapKind kind : kScatteredKinds) {
        const size_t map = map_of(kind);
        if (!maps.has(map)) continue;
        const uint32_t pieces = maps.pieces(map);
        for (uint32_t piece = 0; piece < pieces; ++piece)
            steps.push_back({photons_of(params, kind) / pieces, [=, this](gpu::CommandList& commands) {
                                 if (ahead)
                                     maps.record_traced_on_host(commands, map, ahead->photons(kind).photons);
                                 else
                                     maps.record(commands, map, seed, pass, piece);
                             }});
        if (raster) add_raster_steps(kind, steps);
        add_scatter_steps(kind, steps);
    }
    steps.push_back({0, [this](gpu::CommandList& commands) {
                         if (show_bounces) record_bounce_map_layer(commands);
                         record_combining(commands);
                         commands.copy(bounces, 0, host_bounces, 0, kBounceBytes);
                         commands.host_reads(host_bounces);
                         frame.image().record_readback(commands);
                     }});
}

void ImageSpacePhotonMappingGpu::State::add_raster_steps(PhotonMapKind kind, DeviceFrame::Steps& steps) {
    const size_t map = map_of(kind);
    const auto photons = static_cast<uint32_t>(maps.room(map));
    // Footprints cover as much of the image as they do of the scene's middle, at a guess.
    const double share = double{sqr(first_radius_m / scene.bounds.radius())};
    const double pixels = share * static_cast<double>(points.layout().size.pixels());
    const uint32_t at_once = raster->photons_at_once(pixels);
    for (uint32_t first = 0; first < photons; first += std::min(at_once, photons - first))
        steps.push_back({static_cast<uint64_t>(pixels * std::min(at_once, photons - first) / 32) + 1,
                         [=, this](gpu::CommandList& commands) {
                             const gpu::Scope scope(commands, "splat");
                             const uint32_t end = first + std::min(at_once, photons - first);
                             const PhotonRaster::Pass pass{constants,
                                                           points.points(),
                                                           maps.photons().starts,
                                                           maps.photons().places,
                                                           maps.photons().powers,
                                                           points.sums(),
                                                           frame.image().layers()};
                             raster->record(commands, pass, static_cast<uint32_t>(map), first, end, first == 0);
                             if (end == photons) raster->record_sums(commands, pass, static_cast<uint32_t>(map));
                         }});
}

void ImageSpacePhotonMappingGpu::State::add_scatter_steps(PhotonMapKind kind, DeviceFrame::Steps& steps) {
    // What a block's tests and sums cost, in paths.
    constexpr uint64_t kPathsABlock = 256;
    const size_t map = map_of(kind);
    const auto record_bounds = [=, this](gpu::CommandList& commands) {
        const gpu::Scope scope(commands, "photon_map_build");
        const uint32_t most = batches_of(kind);
        commands.bind(*bound, {gpu::read("constants", constants), gpu::read("grid_starts", maps.photons().starts),
                               gpu::read("grid_places", maps.photons().places), gpu::write("batches", batches),
                               gpu::read_write("photons_by_bounce", bounces)});
        commands.push(gpu::PhotonBatchPush{static_cast<uint32_t>(map), most});
        commands.dispatch_threads(uint64_t{most} * SCATTER_GROUP, SCATTER_GROUP);
    };
    const SplitLayout& layout = points.layout();
    const auto along = [](uint32_t pixels) { return (pixels + SCATTER_BLOCK_SIDE - 1) / SCATTER_BLOCK_SIDE; };
    const uint32_t sub_samples = layout.side > 1 ? along(layout.tile_width) * along(layout.tile_height) : 0;
    const uint32_t blocks = sub_samples + along(layout.size.width) * along(layout.size.height);
    const uint32_t at_once = std::max(static_cast<uint32_t>(device.paths_per_submit() / kPathsABlock), 1u);
    for (uint32_t first = 0; first < blocks; first += at_once)
        steps.push_back(
            {kPathsABlock * std::min(at_once, blocks - first), [=, this](gpu::CommandList& commands) {
                 if (first == 0) record_bounds(commands);
                 const gpu::Scope scope(commands, "splat");
                 const uint32_t end = std::min(first + at_once, blocks);
                 commands.bind(
                     *scatter,
                     {gpu::read("constants", constants), gpu::read("points", points.points()),
                      gpu::read("general_points", points.general()), gpu::read("grid_starts", maps.photons().starts),
                      gpu::read("grid_places", maps.photons().places), gpu::read("map_powers", maps.photons().powers),
                      gpu::read("batches", batches), gpu::read_write("sums", points.sums()),
                      gpu::read_write("device_layers", frame.image().layers())});
                 commands.push(gpu::PhotonScatterPush{first, end, static_cast<uint32_t>(map), batches_of(kind)});
                 commands.dispatch_threads(uint64_t{end - first} * SCATTER_GROUP, SCATTER_GROUP);
             }});
}

void ImageSpacePhotonMappingGpu::State::record_bounce_map_layer(gpu::CommandList& commands) {
    commands.bind(*show_bounces, {gpu::read_write("device_layers", frame.image().layers()),
                                  gpu::read("eye", points.eye()), gpu::read("points", points.points()),
                                  gpu::read("first_hits", maps.tracer(map_of(PhotonMapKind::Global)).bounce_map())});
    commands.push(gpu::BounceMapLayerPush{points.split(), texels});
    commands.dispatch_threads(texels, PHOTON_TRACING_GROUP);
}

void ImageSpacePhotonMappingGpu::State::record_combining(gpu::CommandList& commands) {
    gpu::Buffer& nothing = constants;  // what no shadow is read from
    for (CombineStep& step : combine) {
        const gpu::Scope scope(commands, step.stage);
        commands.bind(step.pipeline,
                      {gpu::read_write("device_layers", frame.image().layers()), gpu::read("constants", constants),
                       gpu::read("points", points.points()), gpu::read_write("sums", points.sums()),
                       gpu::read("eye", points.eye()), gpu::read("lamp_shapes", centres ? centres->shapes() : nothing),
                       gpu::read("unshadowed_lights", centres ? centres->lights() : nothing)});
        commands.push(gpu::ShadowSamples{params.shadow_search_samples, params.shadow_blur_samples});
        commands.dispatch_threads(points.layout().size.pixels(), SCATTER_GROUP);
    }
}

ImageSpacePhotonMappingGpu::ImageSpacePhotonMappingGpu(const ImageSpacePhotonMappingParams& params) : params_(params) {}
ImageSpacePhotonMappingGpu::~ImageSpacePhotonMappingGpu() = default;

uint64_t ImageSpacePhotonMappingGpu::estimate_bytes(const ImageSpacePhotonMappingParams& params,
                                                    const Workload& workload) {
    uint64_t bytes = DeviceFrame::estimate_bytes(workload);
    if (!params.traces_on_host()) return bytes;
    const PhotonYield yield = workload.photon_yield.value_or(kExpectedPhotonYield);
    bytes += PhotonTracer::scratch_bytes(workload.threads);
    for (const PhotonMapKind kind : kScatteredKinds) {
        if (!may_have(params, kind, workload)) continue;
        bytes += PhotonsAhead::bytes_for(stored_by(params, kind, yield));
        if (params.projection_maps) bytes += estimate_guide_bytes(kind, workload);
    }
    return bytes;
}

uint64_t ImageSpacePhotonMappingGpu::estimate_device_bytes(const ImageSpacePhotonMappingParams& params,
                                                           const Workload& workload) {
    const PhotonYield yield = workload.photon_yield.value_or(kExpectedPhotonYield);
    uint64_t bytes = DeviceFrame::estimate_device_bytes(workload) +
                     GBufferGpu::device_bytes(workload.film_size, params.subsampling, workload.needs) +
                     sizeof(gpu::PhotonScatterConstants);
    if (params.shadows_by_centres()) bytes += CentreShadowsGpu::device_bytes(workload.film_size, workload.lights);
    uint64_t most = 0;
    for (const PhotonMapKind kind : kScatteredKinds) {
        if (!may_have(params, kind, workload)) continue;
        const uint64_t expected = expected_of(params, kind);
        const uint64_t room =
            PhotonMapsGpu::room_for(std::max(stored_by(params, kind, yield), static_cast<double>(expected)));
        most = std::max(most, room);
        bytes += PhotonMapsGpu::map_bytes(expected, room) + batches_for(room) * sizeof(gpu::PhotonBatch);
        if (params.traces_on_host())
            bytes += PhotonUploadGpu::bytes_for(room);
        else if (params.projection_maps)
            bytes += estimate_guide_bytes(kind, workload);
        if (kind == PhotonMapKind::Global)
            bytes += PhotonTracerGpu::bounce_map_bytes(bounce_map_texels(params, workload.layers));
    }
    if (most > 0 && params.scatter == PhotonScatter::Raster)
        bytes += PhotonRaster::device_bytes({workload.film_size, params.subsampling});
    if (most > 0 && params.clips()) bytes += EdgeTree::estimate_bytes(workload.triangles);
    return bytes + PhotonMapsGpu::shared_bytes(most);
}

void ImageSpacePhotonMappingGpu::begin(const RenderContext& context, Stats& stats) {
    const Scene& scene = context.scene;
    note_skipped_shading(scene.needs, stats);
    state_ = std::make_unique<State>(context, params_);
    State& state = *state_;

    make_emission(scene, state.emission, stats);
    state.guides.emplace();
    const bool specular = has_specular_surface(scene, params_.glossy_threshold);
    bool any = false;
    uint64_t ahead_bytes = params_.traces_on_host() ? PhotonTracer::scratch_bytes(most_threads()) : 0;
    for (const PhotonMapKind kind : kScatteredKinds) {
        if (const char* why = why_none(params_, kind, state.emission.has_value(), specular)) {
            const uint64_t expected = expected_of(params_, kind);
            const uint64_t room = PhotonMapsGpu::room_for(static_cast<double>(expected));
            stats.skipped.push_back({kind == PhotonMapKind::Global ? "global map" : "caustic map", why,
                                     PhotonMapsGpu::shared_bytes(room) + PhotonMapsGpu::map_bytes(expected, room)});
            continue;
        }
        if (params_.projection_maps)
            state.guides->add(kind, scene, *context.intersector, *state.emission, params_.glossy_threshold,
                              context.seed, context.budget, stats);
        if (params_.traces_on_host()) {
            const uint64_t bytes = PhotonsAhead::bytes_for(stored_by(params_, kind, kExpectedPhotonYield));
            context.budget.require("photons_ahead", bytes + ahead_bytes);
            context.budget.record("photons_ahead", ahead_bytes += bytes);
        }
        state.add_map(context, kind);
        any = true;
    }
    if (!state.ahead) state.guides.reset(), state.emission.reset();  // the device has its own
    if (state.ahead && state.shows_bounces)
        stats.skipped.push_back({"bounce map", "photons are traced on the host, each its own way from the light", 0});
    if (any && params_.clips()) {
        const StageTimer timer(stats, "photon_map_build");
        state.edges.emplace(find_surface_edges(scene, state.first_radius_m));
    }
    const StageTimer timer(stats, "pipelines");
    state.make_combine_pipelines();
    if (!any) return;
    state.make_room();
    state.make_scatter_pipelines();
}

void ImageSpacePhotonMappingGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    if (state.ahead) {
        const StageTimer timer(stats, "photon_tracing");  // for as long as they are waited for
        if (!state.ahead->wait(pass, cancel)) return;
        state.budget.record("photons_ahead", PhotonTracer::scratch_bytes(most_threads()) + state.ahead->bytes());
        state.frame.expect_pass(pass);  // the device first: those of the next pass are traced beside it
        state.ahead->begin(pass + 1);
    }
    const StageTimer timer(stats, "indirect");
    if (!state.frame.run_with_room(pass, stats, cancel, [&] { return state.grow_if_short(); })) return;
    for (const PhotonMapKind kind : kScatteredKinds)
        if (state.maps.has(map_of(kind))) state.add_counts(kind, stats.counts);
    const auto by_bounce = state.host_bounces.as<const uint32_t>();
    for (size_t i = 0; i < Counts::kBounces; ++i) stats.counts.photons_by_bounce[i] += by_bounce[i];
}

void ImageSpacePhotonMappingGpu::expect_pass(uint32_t pass) {
    if (!state_->ahead || state_->ahead->arrived(pass)) DeviceMethod::expect_pass(pass);
}

void ImageSpacePhotonMappingGpu::settle() {
    if (state_->ahead) state_->ahead->stop();
    DeviceMethod::settle();
}

DeviceFrame& ImageSpacePhotonMappingGpu::frame() { return state_->frame; }

}  // namespace photond
