#include "renderer/bidirectional/bidirectional_method_gpu.h"

#include <algorithm>

#include "renderer/bidirectional/eye_paths_gpu.h"
#include "renderer/eye/eye_constants.h"
#include "renderer/eye/path_wavefront_gpu.h"
#include "renderer/frame/device_frame.h"
#include "renderer/transport/light_tables_shared.h"

namespace photond {

namespace {

/// Paths of the eye's that are under way at once at most: each has some 300 bytes.
constexpr uint32_t kMostEyePaths = 1u << 20;

/// Of the device, that a light path's vertices take: what the plan says is saved without.
uint64_t device_bytes_of_path(double vertices, const MergingParams* merging) {
    constexpr uint32_t kPaths = 1u << 20;
    return LightPathsGpu::device_bytes(kPaths, vertices, merging != nullptr, false, {}) / kPaths;
}

BidirectionalPlan pilot_plan(const RenderContext& context, const BidirectionalParams& params, Stats& stats) {
    const BidirectionalScene scene(context, params);
    LightPathTracer light(scene);
    return make_bidirectional_plan(context, params, scene, light, TechniquesBy::Image, device_bytes_of_path, stats);
}

}  // namespace

struct BidirectionalMethodGpu::State {
    State(const RenderContext& render, const BidirectionalParams& parameters, BidirectionalPlan made)
        : params(parameters),
          device(render.device_scene->device()),
          size(render.view.film_size),
          seed(render.seed),
          plan(std::move(made)),
          tiles(eye_tile_count(size)),
          tiles_a_piece(eye_tiles_at_once(tiles, std::min(device.paths_per_submit(), kMostEyePaths))),
          eye(device, "eye", sizeof(gpu::EyeConstants)),
          sampler(device, "sampler", sizeof(gpu::PassSamplerData)),
          frame(render, [this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); }) {
        const gpu::EyeConstants constants =
            make_eye_constants(render.view, params.max_scatterings(), params.roulette_start);
        gpu::upload(device, eye, std::as_bytes(std::span(&constants, 1)));
        const gpu::DeviceScene& scene = *render.device_scene;
        const std::vector<gpu::Specialization> all =
            scene.specialization(std::vector{gpu::specialize(MIS_POWER_ID, params.heuristic == MisHeuristic::Power),
                                             gpu::specialize(LIGHT_SAMPLES_COMPENSATED_ID, true)});
        if (plan.techniques.light_paths == 0) {
            // Nothing is joined, and paths from the eye need no weights but light samples' own: path tracing.
            eye_alone.emplace(scene, tiles_a_piece, all);
        } else {
            light.emplace(scene, plan, params.sampler, seed, size, all);
            eye_paths.emplace(scene, plan.techniques, tiles_a_piece, all);
            plan.coverage.reset();  // on the device now
        }
    }

    void add_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void add_light_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void add_eye_steps(DeviceFrame::Steps& steps);
    /// Paths from the eye, and what they and the camera see of the light's. False: cancelled.
    bool join(Stats& stats, const CancelToken& cancel);
    PathWaveFrame wave_frame() { return {frame.image(), eye, sampler}; }

    const BidirectionalParams& params;
    gpu::Device& device;
    const Size2 size;
    const uint64_t seed;
    BidirectionalPlan plan;
    const uint32_t tiles, tiles_a_piece;
    gpu::Buffer eye, sampler;
    std::optional<LightPathsGpu> light;
    std::optional<EyePathsGpu> eye_paths;
    std::optional<PathWavefrontGpu> eye_alone;
    DeviceFrame frame;  // last: its going waits for work that uses the others
};

BidirectionalMethodGpu::BidirectionalMethodGpu(std::unique_ptr<const BidirectionalParams> params)
    : params_(std::move(params)) {}
BidirectionalMethodGpu::~BidirectionalMethodGpu() = default;

void BidirectionalMethodGpu::check_gpu(const BidirectionalParams& params) {
    if (params.merging() != nullptr && params.merging()->radius_rule == RadiusRule::Trained)
        throw Error(ErrorCode::Unsupported, "/radius_rule",
                    "there is one radius of merging on a GPU; the CPU has trained ones");
    if (params.merging() != nullptr && params.merging()->weights == MergeWeights::CorrelationAware)
        throw Error(ErrorCode::Unsupported, "/weights",
                    "weights of merging are not correlation-aware on a GPU; the CPU has them");
}

uint64_t BidirectionalMethodGpu::estimate_bytes(const BidirectionalParams& params, const Workload& workload) {
    // While the pilots choose there are two of each sampler, the image's and the pilot's; what they take is given back
    // before the first pass. The edges stay, to be sent anew where the vertices ask for more room.
    const uint64_t samplers = LightSampler::estimate_bytes(workload.lights, workload.environment_size) +
                              EmissionSampler::estimate_bytes(workload.lights, workload.environment_size);
    return DeviceFrame::estimate_bytes(workload) + 2 * samplers + LightPathTracer::scratch_bytes(workload.threads) +
           (params.merging() != nullptr ? 2 * EdgeTree::estimate_bytes(workload.triangles) : 0);
}

uint64_t BidirectionalMethodGpu::estimate_device_bytes(const BidirectionalParams& params, const Workload& workload) {
    const bool merges = params.merging() != nullptr;
    const float light_paths = std::min(params.light_paths.value_or(params.adapt ? 2.0f : 1.0f),
                                       most_light_paths(params, workload.film_size, kExpectedLightVertices));
    const uint32_t tiles = eye_tiles_at_once(eye_tile_count(workload.film_size), kMostEyePaths);
    return DeviceFrame::estimate_device_bytes(workload) + sizeof(gpu::PassSamplerData) + sizeof(gpu::EyeConstants) +
           LightPathsGpu::device_bytes(paths_of_pass(light_paths, workload.film_size), kExpectedLightVertices, merges,
                                       params.connections == Connections::OwnPath, workload.film_size) +
           EyePathsGpu::device_bytes(tiles) + (merges ? EdgeTree::estimate_bytes(workload.triangles) : 0);
}

void BidirectionalMethodGpu::begin(const RenderContext& context, Stats& stats) {
    BidirectionalPlan plan = pilot_plan(context, *params_, stats);
    {
        const StageTimer timer(stats, "pipelines");
        state_ = std::make_unique<State>(context, *params_, std::move(plan));
    }
    note_skipped_shading(context.scene.needs, stats);
}

void BidirectionalMethodGpu::State::add_light_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    const uint32_t pieces = light->begin_pass(pass, plan.of_pass(pass));
    steps.push_back({0, [this](gpu::CommandList& commands) { light->record_start(commands); }});
    for (uint32_t piece = 0; piece < pieces; ++piece)
        steps.push_back({device.paths_per_submit(),
                         [this, piece](gpu::CommandList& commands) { light->record_paths(commands, eye, piece); }});
    steps.push_back({0, [this](gpu::CommandList& commands) { light->record_order(commands); }});
}

void BidirectionalMethodGpu::State::add_eye_steps(DeviceFrame::Steps& steps) {
    for (uint32_t first = 0; first < tiles; first += tiles_a_piece) {
        const uint32_t end = std::min(first + tiles_a_piece, tiles);
        steps.push_back({uint64_t{end - first} * kEyeTilePixels, [=, this](gpu::CommandList& commands) {
                             eye_alone->record(commands, wave_frame(), first, end);
                         }});
    }
    steps.push_back({0, [this](gpu::CommandList& commands) { frame.image().record_readback(commands); }});
}

/// Those of the light alone, where there is any: how long paths from the eye are under way is known as they go.
void BidirectionalMethodGpu::State::add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    steps.push_back({0, [=, this](gpu::CommandList& commands) {
                         commands.update(sampler,
                                         PassSampler(params.sampler, seed, RandomDomain::Camera, pass).device_data());
                     }});
    if (light)
        add_light_steps(pass, steps);
    else
        add_eye_steps(steps);
}

bool BidirectionalMethodGpu::State::join(Stats& stats, const CancelToken& cancel) {
    for (uint32_t first = 0; first < tiles; first += tiles_a_piece) {
        const uint32_t end = std::min(first + tiles_a_piece, tiles);
        uint32_t vertex = 0;
        do {
            const auto record = [&](gpu::CommandList& commands) {
                if (vertex == 0) eye_paths->record_start(commands, wave_frame(), first, end);
                eye_paths->record_vertices(commands, wave_frame(), *light, vertex);
            };
            if (!frame.run_more({record}, stats, cancel)) return false;
            vertex += EyePathsGpu::kVertices;
        } while (eye_paths->paths_left() > 0);
    }
    const auto record = [&](gpu::CommandList& commands) {
        light->record_image(commands, frame.image(), eye);
        frame.image().record_readback(commands);
    };
    return frame.run_more({record}, stats, cancel);
}

void BidirectionalMethodGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    const StageTimer timer(stats, "indirect");
    do {
        if (!state.frame.run(pass, stats, cancel)) return;
    } while (state.light && state.light->grow_if_short());
    if (state.light) {
        if (!state.join(stats, cancel)) return;
        state.light->add_to(stats.counts);
    }
    state.frame.read(stats);
}

DeviceFrame& BidirectionalMethodGpu::frame() { return state_->frame; }

}  // namespace photond
