#include "renderer/methods/svo_many_lights/svo_many_lights_gpu.h"

#include "renderer/backends/gpu/device_intersector.h"
#include "renderer/backends/gpu/device_scene.h"
#include "renderer/frame/device_frame.h"
#include "renderer/gbuffer/gbuffer_merge_gpu.h"
#include "renderer/gbuffer/light_depth_maps.h"
#include "renderer/many_lights/camera_importance_gpu.h"
#include "renderer/many_lights/clamp_repayment_gpu.h"
#include "renderer/many_lights/path_selection_gpu.h"
#include "renderer/many_lights/vpl_choice_gpu.h"
#include "renderer/many_lights/vpl_lighting_gpu.h"
#include "renderer/many_lights/vpl_tracer_gpu.h"
#include "renderer/methods/svo_many_lights/svo_settings.h"
#include "renderer/voxels/kept_voxels_gpu.h"

namespace photond {

namespace {

GBufferWalk walk_of(const SvoManyLightsParams& params) {
    return {.split_side = params.split_side(),
            .max_scatterings = params.max_scatterings(),
            .glossy_threshold = params.glossy_threshold,
            .sampler = params.sampler};
}

gpu::GeometryFilter filter_of(const SvoManyLightsParams& params) {
    return {params.filter, params.filter_normal, params.filter_distance};
}

uint32_t most_lights(const SvoManyLightsParams& params) {
    return static_cast<uint32_t>(most_vpls(params.vpls, params.bounces));
}
/// Twice what is expected, so that few passes have more.
uint32_t likely_lights(const SvoManyLightsParams& params) {
    return static_cast<uint32_t>(2 * expected_vpls(params.vpls, params.bounces));
}
bool is_interleaved(const SvoManyLightsParams& params) { return params.vpl_choice == VplChoice::Interleaved; }
VplChoiceSettings choice_of(const SvoManyLightsParams& params) {
    const bool lightcut = params.vpl_choice == VplChoice::Lightcut;
    return {lightcut, lightcut ? params.cut_size : params.resampled_vpls};
}
bool by_camera(const SvoManyLightsParams& params) { return params.placement == VplPlacement::Camera; }

uint64_t caustic_device_bytes(const SvoManyLightsParams& params, uint64_t lights,
                              const std::optional<PhotonYield>& yield) {
    if (params.caustic_photons == 0) return 0;
    return CausticPhotonsGpu::device_bytes(caustics_of(params), yield ? yield->caustic.guided : kExpectedCausticYield,
                                           lights);
}

VplBounceShader bounces_of(const SvoManyLightsParams& params, SparseVoxelOctreeGpu* tree) {
    if (!traces_voxels(params)) return {};
    return {.name = "renderer/methods/svo_many_lights/vpl_bounces_voxels.comp",
            .bindings = {gpu::read("svo_constants", tree->constants()), gpu::read("svo_nodes", tree->nodes()),
                         gpu::read("svo_bricks", tree->bricks()), gpu::read("svo_surfaces", tree->surfaces()),
                         gpu::read("svo_first_triangles", tree->first_triangles())}};
}

}  // namespace

/// What lights take: none where a scene has no light, or no bounce is asked for.
struct SvoLights {
    SvoLights(const gpu::DeviceScene& scene, const SvoManyLightsParams& params, uint64_t seed, float clamp_sq_m2,
              EmissionSampler sampler, FrameOctreeGpu octree, GBufferGpu& buffer, DeviceImage& image,
              const RepaymentAsks& asks, std::unique_ptr<CausticPhotons> caustic_pilot,
              const std::optional<PathPilot>& path_pilot)
        : emission(std::move(sampler)),
          tree(std::move(octree)),
          tracer(scene, emission, tracing_of(params), image.counters(), by_camera(params),
                 bounces_of(params, tree.get())),
          set(scene, most_lights(params), params.connect_threshold, likely_lights(params)),
          lighting(scene, buffer, set, image.counters(), seed,
                   {.visibility = params.visibility,
                    .clamp_sq_m2 = clamp_sq_m2,
                    .roulette = params.roulette,
                    .connect_threshold = params.connect_threshold,
                    .map_resolution = params.shadow_resolution,
                    .voxel_reach_m = voxel_reach_m(params, scene.scene()),
                    .lights_all = is_interleaved(params)}) {
        if (params.visibility == VplVisibility::ShadowMaps)
            maps.emplace(scene, params.shadow_resolution, most_lights(params), image.counters());
        if (by_camera(params)) importance.emplace(scene, buffer, tree.get(), seed, clamp_sq_m2, tracer.map_texels());
        if (path_pilot)
            selection.emplace(scene, tracer, buffer, image.counters(), params.placement, *path_pilot, params.vpls, seed,
                              clamp_sq_m2);
        if (!is_interleaved(params))
            choice.emplace(scene, buffer, set, lighting, image.counters(), params.visibility, choice_of(params));
        if (caustic_pilot) caustics.emplace(scene, std::move(caustic_pilot), seed);
        if (asks.clamped || asks.narrow)
            repayment.emplace(scene, buffer, image, seed, params.sampler, asks, caustics ? &*caustics : nullptr);
    }

    VplVisibilityGpu visibility(VplVisibility kind) { return {kind, tree.get(), maps ? &*maps : nullptr}; }

    const EmissionSampler emission;
    FrameOctreeGpu tree;
    VplTracerGpu tracer;
    VplSetGpu set;
    VplLightingGpu lighting;
    std::optional<VplShadowMapsGpu> maps;
    std::optional<CameraImportanceGpu> importance;
    std::optional<PathSelectionGpu> selection;  // none: placements by texels
    std::optional<VplChoiceGpu> choice;         // none: interleaved
    std::optional<CausticPhotonsGpu> caustics;  // none: caustics are path traced, or not asked for
    std::optional<ClampRepaymentGpu> repayment;
};

struct SvoManyLightsGpu::State {
    State(const RenderContext& context, const SvoManyLightsParams& p, std::unique_ptr<LightDepthMapsGpu> shadows)
        : params(p),
          device(context.device_scene->device()),
          scene(*context.device_scene),
          seed(context.seed),
          layers(context.view.layers),
          light_maps(std::move(shadows)),
          frame(context, [this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); }),
          buffer(scene, context.view, seed, walk_of(p), device_image, {.depth_maps = light_maps.get()}),
          merge(scene, buffer, device_image, layers, filter_of(p)) {
        show_voxels = layer_pipeline("svo_voxels.comp", 0, Layer::Voxels);
        show_vpls = layer_pipeline("svo_vpls.comp", sizeof(gpu::SplitRecord), Layer::Vpls);
    }

    ~State() { frame.end(); }

    /// Null where the layer is not asked for.
    std::unique_ptr<gpu::ComputePipeline> layer_pipeline(const std::string& name, uint32_t push_bytes,
                                                         Layer layer) const {
        if (!layers.has(layer)) return nullptr;
        return std::make_unique<gpu::ComputePipeline>(device, "renderer/methods/svo_many_lights/" + name, push_bytes);
    }

    void add_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void add_light_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void add_lighting_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void record_layers(gpu::CommandList& commands);

    const SvoManyLightsParams& params;
    gpu::Device& device;
    const gpu::DeviceScene& scene;
    const uint64_t seed;
    const LayerSet layers;
    const std::unique_ptr<LightDepthMapsGpu> light_maps;  // null: rays tell
    DeviceFrame frame;
    DeviceImage& device_image = frame.image();
    GBufferGpu buffer;
    GBufferMergeGpu merge;
    std::unique_ptr<gpu::ComputePipeline> show_voxels, show_vpls;
    std::optional<SvoLights> lights;
};

/// The lights of a pass.
void SvoManyLightsGpu::State::add_light_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    const uint32_t texels = lights->tracer.map_texels();
    steps.push_back({texels, [=, this](gpu::CommandList& commands) {
                         lights->tracer.start(seed, pass);
                         lights->lighting.record_constants(commands, pass);
                         lights->tracer.record_map(commands);
                     }});
    if (lights->importance) {
        const uint32_t pieces = lights->importance->pieces();
        for (uint32_t piece = 0; piece < pieces; ++piece)
            steps.push_back(
                {uint64_t{texels} * CAMERA_IMPORTANCE_POINTS / pieces, [=, this](gpu::CommandList& commands) {
                     lights->importance->record(commands, lights->tracer.texels(), lights->tracer.importance(), pass,
                                                piece);
                 }});
    }
    for (uint32_t piece = 0; lights->selection && piece < lights->selection->pieces(); ++piece)
        steps.push_back({lights->selection->paths_of_piece(),
                         [=, this](gpu::CommandList& commands) { lights->selection->record(commands, pass, piece); }});
    steps.push_back(
        {likely_lights(params), [this](gpu::CommandList& commands) {
             VplTracerGpu& tracer = lights->tracer;
             if (!lights->selection) tracer.record_vpls(commands);
             lights->set.record(commands, {tracer.state(), tracer.photons(), tracer.order(), tracer.surfaces()});
             if (lights->choice && lights->selection) lights->selection->record_choices(commands, lights->set);
             if (lights->choice) lights->choice->record_lights(commands);
         }});
    if (lights->maps)
        steps.push_back({uint64_t{likely_lights(params)} * params.shadow_resolution * params.shadow_resolution,
                         [this](gpu::CommandList& commands) {
                             lights->maps->record(commands, lights->set.vpls(), {lights->set.counts(), VPL_COUNT});
                         }});
}

/// What the lights bring to the points, and what the clamp takes.
void SvoManyLightsGpu::State::add_lighting_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    VplLightingGpu& lighting = lights->lighting;
    const uint32_t choice_pieces = lights->choice ? lights->choice->pieces() : 0;
    for (uint32_t piece = 0; piece < choice_pieces; ++piece)
        steps.push_back({lights->choice->paths_of_piece(), [=, this](gpu::CommandList& commands) {
                             lights->choice->record(commands, lights->visibility(params.visibility), piece);
                         }});
    for (uint32_t piece = 0; piece < lighting.pieces() && !lights->choice; ++piece)
        steps.push_back({lighting.paths_of_piece(), [=, this](gpu::CommandList& commands) {
                             lights->lighting.record(commands, lights->visibility(params.visibility), piece);
                         }});
    steps.push_back({0, [this](gpu::CommandList& commands) { record_layers(commands); }});
    for (uint32_t piece = 0; lights->caustics && piece < lights->caustics->pieces(); ++piece)
        steps.push_back({device.paths_per_submit(),
                         [=, this](gpu::CommandList& commands) { lights->caustics->record(commands, pass, piece); }});
    if (!lights->repayment) return;
    for (uint32_t piece = 0; piece < lights->repayment->pieces(); ++piece)
        steps.push_back({buffer.layout().points() / lights->repayment->pieces(), [=, this](gpu::CommandList& commands) {
                             lights->repayment->record(commands, lights->lighting.constants(), pass, piece);
                         }});
}

/// Looks at what the pass worked with, before the repayment is among it.
void SvoManyLightsGpu::State::record_layers(gpu::CommandList& commands) {
    merge.record_split_layers(commands);
    if (!lights) return;
    const uint64_t pixels = buffer.layout().size.pixels();
    if (show_voxels && lights->tree) {
        commands.bind(*show_voxels,
                      {gpu::read_write("device_layers", device_image.layers()), gpu::read("eye", buffer.eye()),
                       gpu::read("svo_constants", lights->tree->constants()),
                       gpu::read("svo_nodes", lights->tree->nodes()), gpu::read("svo_bricks", lights->tree->bricks())});
        commands.dispatch_threads(pixels, SPLIT_GROUP);
    }
    if (show_vpls) {
        commands.bind(*show_vpls, {gpu::read_write("device_layers", device_image.layers()),
                                   gpu::read("eye", buffer.eye()), gpu::read("points", buffer.points()),
                                   gpu::read("counts", lights->set.counts()), gpu::read("vpls", lights->set.vpls())});
        commands.push(buffer.split());
        commands.dispatch_threads(lights->set.most(), VPL_SET_GROUP);
    }
}

void SvoManyLightsGpu::State::add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    for (uint32_t piece = 0; piece < buffer.pieces(); ++piece)
        steps.push_back({buffer.layout().size.pixels() / buffer.pieces(),
                         [=, this](gpu::CommandList& commands) { buffer.record(commands, pass, piece); }});
    if (lights) {
        add_light_steps(pass, steps);
        add_lighting_steps(pass, steps);
    } else {
        steps.push_back({0, [this](gpu::CommandList& commands) { record_layers(commands); }});
    }
    steps.push_back({0, [this](gpu::CommandList& commands) {
                         merge.record(commands);
                         device_image.record_readback(commands);
                     }});
}

SvoManyLightsGpu::SvoManyLightsGpu(const SvoManyLightsParams& params)
    : FollowsFrames(params.incremental, params.vpls), params_(params) {}
SvoManyLightsGpu::~SvoManyLightsGpu() = default;

uint64_t SvoManyLightsGpu::estimate_bytes(const SvoManyLightsParams& params, const Workload& workload) {
    return DeviceFrame::estimate_bytes(workload) + VplsBetweenFrames::bytes_for(params.incremental, params.vpls) +
           (params.bounces > 0 ? EmissionSampler::estimate_bytes(workload.lights, workload.environment_size) : 0) +
           (sends_caustics(params, workload) ? CausticPhotons::estimate_bytes(workload.lights, 1) : 0);
}

uint64_t SvoManyLightsGpu::estimate_device_bytes(const SvoManyLightsParams& params, const Workload& workload) {
    const bool lambert = workload.needs.only_lambert();
    uint64_t bytes = DeviceFrame::estimate_device_bytes(workload) +
                     GBufferGpu::device_bytes(workload.film_size, params.split_side(), workload.needs) +
                     GBufferMergeGpu::device_bytes(workload.film_size, params.split_side(), filter_of(params));
    if (has_light_maps(params, workload.needs)) bytes += LightDepthMaps::guess_bytes(params.direct_resolution);
    if ((workload.lights == 0 && workload.environment_size.pixels() == 0) || params.bounces == 0) return bytes;
    if (!params.clamp_m2) bytes += gpu::DeviceIntersector::batch_bytes();  // the lit area is asked of it
    bytes += VplTracerGpu::device_bytes(tracing_of(params), by_camera(params), lambert, workload.lights) +
             VplSetGpu::device_bytes(most_lights(params), lambert) + VplLightingGpu::device_bytes() +
             ClampRepaymentGpu::device_bytes();
    if (selects_paths(params.placement)) bytes += PathSelectionGpu::device_bytes(params.placement, params.vpls);
    if (params.visibility == VplVisibility::ShadowMaps)
        bytes += VplShadowMapsGpu::device_bytes(params.shadow_resolution, most_lights(params));
    if (params.needs_voxels(workload.layers))
        bytes += SparseVoxelOctreeGpu::guess_device_bytes(params.voxel_resolution, traces_voxels(params),
                                                          workload.triangles);
    if (sends_caustics(params, workload)) bytes += caustic_device_bytes(params, workload.lights, workload.photon_yield);
    if (!is_interleaved(params))
        bytes += VplChoiceGpu::device_bytes(workload.film_size, most_lights(params), choice_of(params));
    return bytes;
}

void SvoManyLightsGpu::begin(const RenderContext& context, Stats& stats) {
    const Scene& scene = context.scene;
    std::unique_ptr<LightDepthMapsGpu> light_maps;
    if (has_light_maps(params_, scene.needs))
        light_maps =
            std::make_unique<LightDepthMapsGpu>(*context.device_scene, params_.direct_resolution, params_.pcf, stats);
    {
        const StageTimer timer(stats, "pipelines");
        state_ = std::make_unique<State>(context, params_, std::move(light_maps));
    }
    State& state = *state_;
    note_skipped_shading(scene.needs, stats);

    const char* nothing = params_.bounces == 0 ? "bounces is 0" : nullptr;
    std::optional<EmissionSampler> emission;
    if (!nothing) {
        emission.emplace(scene);
        if (!(emission->total_power_w() > 0)) nothing = "the scene has no light";
    }
    if (nothing) {
        stats.skipped.push_back(
            {"virtual point lights", nothing,
             VplSetGpu::device_bytes(std::max(most_lights(params_), 1u), scene.needs.only_lambert())});
        return;
    }
    context.budget.record("emission_sampler", emission->bytes());
    FrameOctreeGpu tree;
    if (params_.needs_voxels(context.view.layers)) {
        tree = {context.kept_voxels, *context.device_scene, make_voxel_grid(scene.bounds, params_.voxel_resolution),
                traces_voxels(params_), stats};
    } else {
        stats.skipped.push_back({"sparse voxel octree", "neither visibility, bounces nor layers ask for it",
                                 SparseVoxelOctreeGpu::guess_device_bytes(
                                     params_.voxel_resolution, traces_voxels(params_), scene.triangle_count)});
    }
    float clamp_sq_m2;
    {
        const StageTimer timer(stats, "rsm");
        const auto lit_area_m2 = [&] {
            const VplTracer tracer(scene, *context.intersector, *context.intersector, *emission, tracing_of(params_));
            return static_cast<float>(tracer.lit_area_m2(context.seed));
        };
        clamp_sq_m2 = params_.clamp_m2 ? *params_.clamp_m2 : default_clamp_sq_m2(lit_area_m2(), params_.vpls);
    }
    std::optional<PathPilot> path_pilot;
    if (frames_.on() || selects_paths(params_.placement)) {
        const VplTracer tracer(scene, *context.intersector, *context.intersector, *emission, tracing_of(params_));
        if (frames_.on()) frames_.renew(tracer, *emission, context, stats);
        if (selects_paths(params_.placement))
            path_pilot =
                find_path_pilot(params_.placement, tracer,
                                CameraImportance(scene, *context.intersector, context.view, clamp_sq_m2, context.seed),
                                *context.intersector, params_.vpls, context.seed, stats);
    }
    const CausticSettings caustics = caustics_of(params_);
    std::unique_ptr<CausticPhotons> caustic_pilot;
    if (const char* why = why_no_caustics(params_, has_specular_surface(scene, caustics.glossy_threshold)))
        stats.skipped.push_back(
            {"caustic map", why,
             caustic_device_bytes(params_, scene.triangle_lights.size() + scene.punctual_lights.size(), {})});
    else
        caustic_pilot =
            std::make_unique<CausticPhotons>(scene, *context.intersector, *emission, caustics, context.seed, stats);
    if (caustic_pilot) context.budget.record("caustic_photons", caustic_pilot->bytes());
    const RepaymentAsks asks{.clamped = clamp_sq_m2 > 0 && (params_.repay || state.layers.has(Layer::Clamped)),
                             .repaid = params_.repay,
                             .narrow = asks_narrow_lobes(params_, scene.needs)};
    const StageTimer timer(stats, "pipelines");
    state.lights.emplace(*context.device_scene, params_, context.seed, clamp_sq_m2, std::move(*emission),
                         std::move(tree), state.buffer, state.device_image, asks, std::move(caustic_pilot), path_pilot);
    if (frames_.on()) state.lights->tracer.start(frames_.seed(), frames_.paths());
}

void SvoManyLightsGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    const StageTimer timer(stats, "indirect");
    const auto grows = [&] {
        if (!state.lights) return false;
        const bool voxels = state.lights->tree.settle(stats);
        return (state.lights->caustics && state.lights->caustics->grow_if_short()) || voxels;
    };
    if (!state.frame.run_with_room(pass, stats, cancel, grows) || !state.lights) return;
    if (state.lights->caustics) state.lights->caustics->add_to(stats.counts);
    state.lights->tracer.add_to(stats.counts);
    if (state.lights->selection) state.lights->selection->add_to(stats.counts);
    stats.counts.vpls += state.lights->set.lights_of_pass();
}

DeviceFrame& SvoManyLightsGpu::frame() { return state_->frame; }

}  // namespace photond
