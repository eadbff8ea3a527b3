#include "renderer/methods/visibility_filtering/visibility_filtering_gpu.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "renderer/frame/device_frame.h"
#include "renderer/methods/visibility_filtering/visibility_lists_gpu.h"
#include "renderer/scene/scene.h"
#include "renderer/scene/surface_area.h"
#include "renderer/voxels/kept_voxels_gpu.h"

namespace photond {

namespace {

constexpr uint64_t kWorldRays = 0x776f726c64;  // stands for a seed

static_assert(uint32_t(ProxyVisibility::Discs) == PROXY_VISIBILITY_DISCS &&
              uint32_t(ProxyVisibility::Svo) == PROXY_VISIBILITY_SVO &&
              uint32_t(ProxyVisibility::Rays) == PROXY_VISIBILITY_RAYS && uint32_t(ListKind::Counts) == LISTS_COUNTS &&
              uint32_t(ListKind::Bits) == LISTS_BITS && uint32_t(ListKind::Indices) == LISTS_INDICES);

GBufferWalk walk_of(const VisibilityFilteringParams& params) {
    return {.split_side = params.subsampling,
            .max_scatterings = params.max_scatterings(),
            .glossy_threshold = params.glossy_threshold,
            .sampler = params.sampler};
}

/// Of places that share their rays where those are tied to the world: a power of two, so that places stay in their
/// cells where the scene's box, and voxels, change with what moves; below a voxel, so that lists of one window have
/// various rays.
float world_cell_m(float voxel_m) { return std::exp2(std::round(std::log2(voxel_m / 4))); }

/// Why there is no indirect light; null: there may be some.
const char* why_dark(const VisibilityFilteringParams& params, bool lights, bool surfaces) {
    if (params.bounces == 0) return "bounces is 0";
    if (!lights) return "the scene has no light";
    return surfaces ? nullptr : "the scene has no surface";
}

std::unique_ptr<LightDepthMapsGpu> make_depth_maps(const gpu::DeviceScene& scene,
                                                   const VisibilityFilteringParams& params, Stats& stats) {
    if (params.proxy_shadows != ProxyShadows::DepthMaps || scene.scene().punctual_lights.empty()) return nullptr;
    constexpr uint32_t kPcf = 3;
    return std::make_unique<LightDepthMapsGpu>(scene, params.depth_map_resolution, kPcf, stats);
}

std::vector<gpu::Specialization> merge_constants(const VisibilityFilteringParams& params) {
    return {gpu::specialize(UPSAMPLING_ID, static_cast<uint32_t>(params.upsampling)),
            gpu::specialize(LISTS_ID, params.asks_rays() ? LISTS_NONE : static_cast<uint32_t>(params.lists))};
}

std::string visibility_shader(const char* name) { return "renderer/methods/visibility_filtering/" + std::string(name); }

}  // namespace

struct VisibilityFilteringGpu::State {
    /// What there is where light is.
    struct Lit {
        Lit(const gpu::DeviceScene& scene, KeptVoxels* voxels, State& state, const VisibilityFilteringParams& params,
            Stats& stats);
        void make_room(const VisibilityFilteringParams& params, uint32_t pass);

        const std::unique_ptr<LightDepthMapsGpu> depth_maps;  // null: nobody asks
        PointProxiesGpu proxies;
        FrameOctreeGpu tree;
        std::optional<KeptListsGpu> kept;         // null: frames stand alone
        std::optional<VisibilityListsGpu> lists;  // null: shadow rays tell
        gpu::ComputePipeline gather, merge;
    };

    State(const RenderContext& context, const VisibilityFilteringParams& p, const ListsBetweenFrames& between)
        : params(p),
          frames(between),
          scene(*context.device_scene),
          device(scene.device()),
          seed(context.seed),
          constants(device, "visibility_lists", sizeof(gpu::VisibilityConstants)),
          frame(context, [this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); }),
          points(scene, context.view, seed, walk_of(p), frame.image()) {}
    ~State() { frame.end(); }

    gpu::VisibilityConstants constants_of(uint32_t pass) const;
    void add_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void add_light_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void record_gather(gpu::CommandList& commands, uint32_t first, uint32_t end);
    void record_merge(gpu::CommandList& commands);

    const VisibilityFilteringParams& params;
    const ListsBetweenFrames& frames;
    const gpu::DeviceScene& scene;
    gpu::Device& device;
    const uint64_t seed;
    gpu::Buffer constants;
    DeviceFrame frame;
    GBufferGpu points;
    std::optional<Lit> lit;  // null: there is no indirect light
};

VisibilityFilteringGpu::State::Lit::Lit(const gpu::DeviceScene& scene, KeptVoxels* voxels, State& state,
                                        const VisibilityFilteringParams& params, Stats& stats)
    : depth_maps(make_depth_maps(scene, params, stats)),
      proxies(scene, depth_maps.get(), state.frame.image().counters(), state.seed, params.proxies,
              params.glossy_threshold),
      tree(params.visibility == ProxyVisibility::Svo
               ? FrameOctreeGpu(voxels, scene, make_voxel_grid(scene.scene().bounds, params.voxel_resolution), false,
                                stats)
               : FrameOctreeGpu()),
      gather(scene.device(), visibility_shader("gather.comp"), sizeof(gpu::ListsPush), &scene.set(),
             scene.specialization(std::vector{
                 gpu::specialize(UPSAMPLING_ID, static_cast<uint32_t>(params.upsampling)),
                 gpu::specialize(PROXY_VISIBILITY_ID, static_cast<uint32_t>(params.visibility)),
                 gpu::specialize(LISTS_ID, static_cast<uint32_t>(params.lists)),
                 gpu::specialize(PAPER_SPECULAR_ID, params.specular == ProxySpecular::Paper),
                 gpu::specialize(PAPER_NORMALISATION_ID, params.normalisation == ListNormalisation::Paper)})),
      merge(scene.device(), visibility_shader("merge.comp"), 0, &scene.set(),
            scene.specialization(merge_constants(params))) {
    if (state.frames.keeps())
        kept.emplace(scene, state.points, proxies, tree.get(), state.constants, state.frame.image().counters(), params,
                     state.frames);
    if (!params.asks_rays())
        lists.emplace(scene, state.points, proxies, tree.get(), state.constants, state.frame.image().counters(), params,
                      kept ? &*kept : nullptr);
}

void VisibilityFilteringGpu::State::Lit::make_room(const VisibilityFilteringParams& params, uint32_t pass) {
    proxies.cut_voxels(params.voxels_of_pass(pass));
    if (lists) lists->make_room(proxies.grid().slots);
}

gpu::VisibilityConstants VisibilityFilteringGpu::State::constants_of(uint32_t pass) const {
    const Size2 size = points.layout().size, marching = VisibilityListsGpu::lists_of(size, params.march_subsampling);
    const uint32_t voxels = lit->proxies.grid().slots;
    const float share = params.share_of_pass(pass), per_m2 = lit->proxies.per_m2();
    const float disc_m = std::sqrt(std::numbers::inv_pi_v<float> / per_m2);  // of a proxy's share of the surface
    return {.grid = lit->proxies.grid(),
            .split = points.split(),
            .march_side = params.march_subsampling,
            .march_columns = marching.width,
            .march_rows = marching.height,
            .words = lit->lists ? VisibilityListsGpu::words_before(params.lists, voxels) : lit->proxies.words(),
            .list_words = lit->lists ? VisibilityListsGpu::words_after(params.lists, voxels) : 0,
            .rays = params.rays,
            .filter_side = params.filter_side,
            .filter_normal = params.filter_normal,
            .filter_distance = params.filter_distance,
            .disc_radius_m = params.disc_scale * disc_m,
            .near_m = params.near_voxels * lit->proxies.cell_m(),
            .most_seen = params.most_seen,
            .softening_sq_m2 = sqr(share * disc_m),
            .proxies_per_m2 = per_m2,
            .glossy_threshold = params.glossy_threshold,
            .world_cell_m = world_cell_m(lit->proxies.cell_m()),
            .key = static_cast<uint32_t>(hash64(hash64(seed) + pass)),
            .world_key = static_cast<uint32_t>(hash64(hash64(kWorldRays + frames.turn()) + pass)),
            .kept = lit->kept ? lit->kept->kept() : gpu::KeptConstants{}};
}

void VisibilityFilteringGpu::State::add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    for (uint32_t piece = 0; piece < points.pieces(); ++piece)
        steps.push_back({points.layout().size.pixels() / points.pieces(),
                         [=, this](gpu::CommandList& commands) { points.record(commands, pass, piece); }});
    if (lit) add_light_steps(pass, steps);
    steps.push_back({0, [this](gpu::CommandList& commands) {
                         if (lit) record_merge(commands);
                         frame.image().record_readback(commands);
                     }});
}

void VisibilityFilteringGpu::State::add_light_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    lit->make_room(params, pass);  // the device does nothing now: the pass before is done
    const uint32_t proxy_pieces = lit->proxies.pieces();
    for (uint32_t piece = 0; piece < proxy_pieces; ++piece)
        steps.push_back({params.proxies / proxy_pieces, [=, this](gpu::CommandList& commands) {
                             if (piece == 0) commands.update(constants, constants_of(pass));
                             lit->proxies.record(commands, pass, piece);
                         }});
    if (lit->lists)
        for (uint32_t piece = 0; piece < lit->lists->pieces(); ++piece)
            steps.push_back({lit->lists->paths_of_piece(),
                             [=, this](gpu::CommandList& commands) { lit->lists->record(commands, piece); }});
    // What a point costs, in paths: a far voxel is a load and a few products, or a shadow ray; a path is a dozen rays.
    const uint64_t voxels_a_path = params.asks_rays() ? 8 : 32;
    const uint64_t cost = std::max<uint64_t>(lit->proxies.grid().slots / voxels_a_path, 1);
    const auto at_once = static_cast<uint32_t>(std::max<uint64_t>(device.paths_per_submit() / cost, LISTS_GROUP) /
                                               LISTS_GROUP * LISTS_GROUP);
    const uint32_t all = points.layout().points();
    for (uint32_t first = 0; first < all; first += at_once)
        steps.push_back({at_once * cost, [=, this](gpu::CommandList& commands) {
                             record_gather(commands, first, std::min(first + at_once, all));
                         }});
}

void VisibilityFilteringGpu::State::record_gather(gpu::CommandList& commands, uint32_t first, uint32_t end) {
    const gpu::Scope scope(commands, "gather");
    commands.bind(
        lit->gather,
        {gpu::read("constants", constants), gpu::read("points", points.points()),
         gpu::read("general_points", points.general()), gpu::read("grid_places", lit->proxies.sorted().places),
         gpu::read("map_powers", lit->proxies.sorted().powers), gpu::read("voxels", lit->proxies.voxels()),
         gpu::read("lists", lit->lists ? lit->lists->lists() : lit->proxies.lit_words()),
         gpu::read("running_sums", lit->proxies.running_sums()), gpu::write("sums", points.sums()),
         gpu::read_write("device_counters", frame.image().counters())});
    commands.push(gpu::ListsPush{first, end});
    commands.dispatch_threads(end - first, LISTS_GROUP);
}

void VisibilityFilteringGpu::State::record_merge(gpu::CommandList& commands) {
    const gpu::Scope scope(commands, "upsample");
    gpu::Buffer& lit_words = lit->proxies.lit_words();  // and what stands where there are no lists
    commands.bind(
        lit->merge,
        {gpu::read_write("device_layers", frame.image().layers()), gpu::read("constants", constants),
         gpu::read("points", points.points()), gpu::read("sums", points.sums()),
         gpu::read("lists", lit->lists ? lit->lists->before_filter() : lit_words),
         gpu::read("filtered", lit->lists ? lit->lists->lists() : lit_words),
         gpu::read("grid_starts", lit->proxies.sorted().starts), gpu::read("grid_places", lit->proxies.sorted().places),
         gpu::read("map_powers", lit->proxies.sorted().powers), gpu::read("lit_words", lit_words)});
    commands.dispatch_threads(points.layout().size.pixels(), LISTS_GROUP);
}

VisibilityFilteringGpu::VisibilityFilteringGpu(const VisibilityFilteringParams& params)
    : FollowsFrames(params), params_(params) {}
VisibilityFilteringGpu::~VisibilityFilteringGpu() = default;

uint64_t VisibilityFilteringGpu::estimate_bytes(const VisibilityFilteringParams& params, const Workload& workload) {
    return DeviceFrame::estimate_bytes(workload) + ListsBetweenFrames::bytes_for(params, workload.film_size);
}

uint64_t VisibilityFilteringGpu::estimate_device_bytes(const VisibilityFilteringParams& params,
                                                       const Workload& workload) {
    uint64_t bytes = DeviceFrame::estimate_device_bytes(workload) +
                     GBufferGpu::device_bytes(workload.film_size, params.subsampling, workload.needs) +
                     sizeof(gpu::VisibilityConstants);
    if (why_dark(params, workload.lights > 0 || workload.environment_size.pixels() > 0, true)) return bytes;
    bytes += PointProxiesGpu::device_bytes(params.proxies, params.voxels, workload.triangles);
    if (params.proxy_shadows == ProxyShadows::DepthMaps && workload.needs.punctual_lights)
        bytes += LightDepthMaps::guess_bytes(params.depth_map_resolution);
    if (params.visibility == ProxyVisibility::Svo)
        bytes += SparseVoxelOctreeGpu::guess_device_bytes(params.voxel_resolution, false, workload.triangles);
    if (!params.asks_rays()) bytes += VisibilityListsGpu::device_bytes(workload.film_size, params);
    if (params.kept_lists > 0) bytes += KeptListsGpu::device_bytes(KeptLayout(workload.film_size, params));
    return bytes;
}

void VisibilityFilteringGpu::begin(const RenderContext& context, Stats& stats) {
    const Scene& scene = context.scene;
    note_skipped_shading(scene.needs, stats);
    frames_.begin(context);
    state_ = std::make_unique<State>(context, params_, frames_);
    if (frames_.keeps())
        context.budget.record("kept_lists", ListsBetweenFrames::bytes_for(params_, context.view.film_size));
    const Needs& needs = scene.needs;
    const bool lights = needs.area_lights || needs.punctual_lights || needs.environment;
    if (const char* why = why_dark(params_, lights, surface_area_m2(scene) > 0)) {
        stats.skipped.push_back({"point proxies", why,
                                 PointProxiesGpu::device_bytes(params_.proxies, params_.voxels, scene.triangle_count)});
        return;
    }
    const StageTimer timer(stats, "pipelines");
    state_->lit.emplace(*context.device_scene, context.kept_voxels, *state_, params_, stats);
    state_->lit->make_room(params_, 0);
}

void VisibilityFilteringGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    const StageTimer timer(stats, "indirect");
    State& state = *state_;
    const auto grows = [&] { return state.lit && state.lit->tree.settle(stats); };
    if (!state.frame.run_with_room(pass, stats, cancel, grows)) return;
    if (state.lit) {
        stats.counts.vpls += state.lit->proxies.count();
        stats.counts.nan_samples += state.lit->proxies.nan_count();
    }
    if (state.lit && state.lit->kept) state.lit->kept->leave(frames_);
}

DeviceFrame& VisibilityFilteringGpu::frame() { return state_->frame; }

}  // namespace photond
