#include "renderer/progressive/progressive_mapping_gpu.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "protocol/error.h"
#include "renderer/eye/eye_constants.h"
#include "renderer/frame/device_frame.h"
#include "renderer/gathering/expected_photons.h"
#include "renderer/gathering/gathering_shared.h"
#include "renderer/photons/disc_coverage.h"
#include "renderer/photons/photon_maps_gpu.h"
#include "renderer/photons/surface_edges.h"
#include "renderer/progressive/disc_radii.h"
#include "renderer/progressive/global_radii.h"
#include "renderer/progressive/point_radii_gpu.h"
#include "renderer/progressive/progressive_shared.h"
#include "renderer/progressive/trained_radii.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/light_sampling.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

namespace {

static_assert(DISC_SECTORS == DiscMoments::kSectors);

/// Of PhotonMapsGpu: where the pilot of a map stands.
constexpr size_t pilot_of(PhotonMapKind kind) { return kPhotonMapKinds.size() + index_of(kind); }

uint32_t rule_of(const ProgressiveParams& params) {
    switch (params.radius_rule) {
        case RadiusRule::Global: return RADIUS_RULE_GLOBAL;
        case RadiusRule::Trained: return RADIUS_RULE_TRAINED;
        case RadiusRule::Local: return RADIUS_RULE_LOCAL;
        case RadiusRule::Tested: return params.test == CurvatureTest::Radial ? RADIUS_RULE_RADIAL : RADIUS_RULE_SECTOR;
    }
    return RADIUS_RULE_GLOBAL;
}

/// Photons that a map is laid out for, whatever it then stores: its order must be the same in each pass.
uint64_t expected_photons(PhotonMapKind kind, uint32_t paths) {
    return static_cast<uint64_t>(yield_of(kExpectedPhotonYield, kind).unguided * paths) + 1;
}

/// Whether points find their first radius by a pilot of their own on the device.
bool has_device_pilots(const ProgressiveParams& params) {
    return !params.passes_stand_alone() && !params.radius_m && !params.radius_relative;
}

}  // namespace

struct ProgressiveMappingGpu::State {
    State(const RenderContext& render, const ProgressiveParams& parameters, Stats& stats)
        : params(parameters),
          context(render),
          on_device(*render.device_scene),
          device(on_device.device()),
          limits(render.scene.bounds.radius()),
          tiles(eye_tile_count(render.view.film_size)),
          tiles_a_piece(std::clamp(device.paths_per_submit() / kEyeTilePixels, 1u, std::max(tiles, 1u))),
          photons(render, parameters, stats),
          maps(on_device),
          eye(device, "eye", sizeof(gpu::EyeConstants)),
          sampler(device, "sampler", sizeof(gpu::PassSamplerData)),
          told(device, "progressive_mapping", sizeof(gpu::ProgressiveConstants)),
          nothing(device, "radii", sizeof(float)),
          frame(render, [this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); }) {}

    void make_radii(const std::string& state_before, Stats& stats);
    void upload_radius_maps();
    void make_room();
    void make_pipeline();
    void add_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void add_photon_steps(size_t map, uint64_t seed, uint32_t pass, DeviceFrame::Steps& steps);
    void begin_pass(uint32_t pass);
    void record_eye(uint32_t piece, gpu::CommandList& commands);
    bool grow_if_short();
    float cell_m(PhotonMapKind kind) const;
    bool wanted(PhotonMapKind kind) const { return photons.wanted(kind); }
    /// Of the records of all points.
    uint64_t points_bytes() const {
        const uint64_t maps_with_points = uint64_t{wanted(PhotonMapKind::Global)} + wanted(PhotonMapKind::Caustic);
        return maps_with_points * context.view.film_size.pixels() * bytes_of_point(params);
    }
    gpu::Buffer& points_before() { return points ? points->before() : nothing; }
    gpu::Buffer& points_after() { return points ? points->after() : nothing; }

    const ProgressiveParams& params;
    const RenderContext context;
    const gpu::DeviceScene& on_device;
    gpu::Device& device;
    const RadiusLimits limits;
    const uint32_t tiles, tiles_a_piece;
    ProgressivePhotons photons;  // which are wanted, their guide, and the pilots of the rules that are the host's
    std::optional<GlobalRadii> global;
    std::optional<TrainedRadii> trained;
    std::optional<PointRadiiGpu> points;
    std::optional<EdgeTree> edges;
    PhotonMapsGpu maps;  // of the pass, by kind, and then the pilots
    bool pilots_stand = false;
    gpu::ProgressiveConstants constants{};
    gpu::Buffer eye, sampler, told, nothing, radius_maps;
    std::optional<gpu::ComputePipeline> eye_pass;
    DeviceFrame frame;  // last: its going waits for work that uses the others
};

ProgressiveMappingGpu::ProgressiveMappingGpu(std::unique_ptr<const ProgressiveParams> params)
    : params_(std::move(params)) {}
ProgressiveMappingGpu::~ProgressiveMappingGpu() = default;

uint64_t ProgressiveMappingGpu::estimate_bytes(const ProgressiveParams& params, const Workload& workload) {
    const DiscRadiiBytes radii = disc_radii_bytes(params, 1, workload);
    // The maps are the device's. What pilots of the host's rules take is given back before the first pass.
    const uint64_t bytes =
        DeviceFrame::estimate_bytes(workload) + ProgressivePhotons::estimate_emission_bytes(params, workload);
    if (!params.passes_stand_alone()) return bytes + PointRadiiGpu::host_bytes(radii.state);
    return bytes + radii.kept + radii.before + LightSampler::estimate_bytes(workload.lights, workload.environment_size);
}

uint64_t ProgressiveMappingGpu::estimate_device_bytes(const ProgressiveParams& params, const Workload& workload) {
    uint64_t bytes = DeviceFrame::estimate_device_bytes(workload) + sizeof(gpu::PassSamplerData) +
                     sizeof(gpu::EyeConstants) + sizeof(gpu::ProgressiveConstants);
    if (params.boundary == DiscBoundary::Clip) bytes += EdgeTree::estimate_bytes(workload.triangles);
    const DiscRadiiBytes radii = disc_radii_bytes(params, 1, workload);
    if (!params.passes_stand_alone())
        bytes += PointRadiiGpu::device_bytes(radii.state);
    else
        bytes += radii.kept;
    uint64_t most = 0;
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        const uint64_t stored = ProgressivePhotons::expected_photons(kind, params, workload);
        if (stored == 0) continue;
        const uint64_t expected = expected_photons(kind, ProgressivePhotons::paths(kind, params));
        const uint64_t room = PhotonMapsGpu::room_for(static_cast<double>(std::max(stored, expected)));
        most = std::max(most, room);
        bytes += (has_device_pilots(params) ? 2 : 1) * PhotonMapsGpu::map_bytes(expected, room);
        if (kind == PhotonMapKind::Caustic && params.projection_maps)
            bytes += ProjectionMap::estimate_bytes(workload.lights);
    }
    return bytes + PhotonMapsGpu::shared_bytes(most);
}

void ProgressiveMappingGpu::go_on_from(const std::string& state) {
    check_points_to_go_on_from(*params_, state);
    state_before_ = state;
}

/// By the rule, where there are photons; those of the host's rules trace their pilots.
void ProgressiveMappingGpu::State::make_radii(const std::string& state_before, Stats& stats) {
    const DiscRadiiInputs inputs{
        .context = context, .params = params, .photons = photons, .hit_point_sets = 1, .state = state_before};
    switch (params.radius_rule) {
        case RadiusRule::Global: global.emplace(inputs, stats); break;
        case RadiusRule::Trained: trained.emplace(inputs, stats); break;
        case RadiusRule::Local:
        case RadiusRule::Tested:
            context.budget.require("radii", PointRadiiGpu::host_bytes(points_bytes()));
            points.emplace(device, params, context.view.film_size.pixels(), photons, state_before);
            context.budget.record("radii", PointRadiiGpu::host_bytes(points_bytes()));
            for (const PhotonMapKind kind : kPhotonMapKinds)
                constants.radii[index_of(kind)].first_word = points->first_word(kind);
            break;
    }
}

/// The trained radii, for the shader.
void ProgressiveMappingGpu::State::upload_radius_maps() {
    std::vector<gpu::RadiusMapRecord> records;
    if (trained) {
        for (const PhotonMapKind kind : kPhotonMapKinds) {
            gpu::MapRadiiConstants& radii = constants.radii[index_of(kind)];
            const RadiusMap& map = trained->first_m(kind);
            radii.first_node = static_cast<uint32_t>(records.size());
            radii.first_leaf = radii.first_node + map.device_leaves();
            const std::vector<gpu::RadiusMapRecord> of_map = map.device_records();
            records.insert(records.end(), of_map.begin(), of_map.end());
        }
        context.budget.record("radii", trained->bytes());
    }
    radius_maps = gpu::make_buffer(device, "radii", std::span<const gpu::RadiusMapRecord>(records));
}

/// By what the cells of a map are cut: most of its discs are about as large.
float ProgressiveMappingGpu::State::cell_m(PhotonMapKind kind) const {
    if (global) return *global->grid_radius_m(kind);
    if (trained) return trained->share() * trained->first_m(kind).median_m();
    if (const auto mean_m = points->mean_radius_m(kind)) return *mean_m;
    if (constants.first_radius_m > 0) return constants.first_radius_m;
    return cell_for_nearest(context.scene.bounds, kind, expected_photons(kind, photons.paths(kind)),
                            params.nearest_photons, limits.most_m);
}

void ProgressiveMappingGpu::State::make_room() {
    // Behind the grids' own words: shaders may bind no more buffers.
    const std::vector<uint32_t> words = edges ? edges->device_words() : std::vector<uint32_t>();
    maps.make_room(words);
    if (edges) constants.estimate.coverage = edges->device_constants(maps.first_word());
    pilots_stand = false;
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        if (!maps.has(pilot_of(kind))) continue;
        const float begin_m = cell_for_nearest(context.scene.bounds, kind, expected_photons(kind, photons.paths(kind)),
                                               params.nearest_photons, limits.most_m);
        constants.radii[index_of(kind)].pilot = {maps.cut_cells(pilot_of(kind), begin_m), limits.most_m,
                                                 params.nearest_photons};
    }
}

void ProgressiveMappingGpu::State::make_pipeline() {
    const LayerSet& layers = context.view.layers;
    const std::vector<gpu::Specialization> fixed{
        gpu::specialize(SEARCH_NEAREST_ID, false),
        gpu::specialize(SOFT_DISC_ID, false),
        gpu::specialize(DISC_COVERAGE_ID, edges.has_value()),
        gpu::specialize(DISC_MOMENTS_ID, layers.has(Layer::BiasEstimate) || params.radius_rule == RadiusRule::Tested),
        gpu::specialize(RADIUS_RULE_ID, rule_of(params)),
        gpu::specialize(GLOBAL_MAP_ID, wanted(PhotonMapKind::Global)),
        gpu::specialize(CAUSTIC_MAP_ID, wanted(PhotonMapKind::Caustic))};
    eye_pass.emplace(device, "renderer/progressive/progressive_mapping.comp", sizeof(gpu::ProgressivePush),
                     &on_device.set(), on_device.specialization(fixed));
}

void ProgressiveMappingGpu::begin(const RenderContext& context, Stats& stats) {
    state_ = std::make_unique<State>(context, *params_, stats);
    State& state = *state_;
    const Scene& scene = context.scene;
    if (!scene.needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});
    const gpu::EyeConstants eye = make_eye_constants(context.view, params_->max_scatterings(), ROULETTE_START);
    gpu::upload(state.device, state.eye, std::as_bytes(std::span(&eye, 1)));

    const Kernel kernel(params_->kernel, params_->cone_k);
    const std::optional<float> first_m = params_->first_radius_m(scene.bounds.radius());
    state.constants = {
        .estimate = {.kernel = kernel.device_record(), .disc_thickness_m = params_->disc_thickness_m.value_or(-1.0f)},
        .share = 1,
        .first_radius_m = first_m.value_or(0.0f),
        .least_radius_m = state.limits.least_m,
        .most_radius_m = state.limits.most_m,
        .alpha = params_->alpha,
        .bias_factor = 2 * kernel.mean_q_sq(),
        .glossy_threshold = params_->glossy_threshold};
    if (params_->boundary == DiscBoundary::Clip && state.photons.any()) {
        const float most_m = first_m.value_or(state.limits.most_m);
        state.edges.emplace(find_surface_edges(scene, most_m));
    }
    if (state.photons.any()) state.make_radii(state_before_, stats);
    state.upload_radius_maps();
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        if (!state.wanted(kind)) continue;
        const PhotonTracing tracing = state.photons.tracing(kind);
        const uint64_t expected = expected_photons(kind, tracing.photons);
        state.maps.add(index_of(kind), tracing, expected);
        if (has_device_pilots(*params_)) state.maps.add(pilot_of(kind), tracing, expected);
    }
    state.make_room();
    state.make_pipeline();
}

/// What the shader is told of the pass.
void ProgressiveMappingGpu::State::begin_pass(uint32_t pass) {
    if (global) global->begin_pass(pass);
    if (trained) trained->begin_pass(pass);
    if (points) points->begin_pass(pass);
    if (trained) constants.share = trained->share();
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        if (!wanted(kind)) continue;
        const float radius_m = cell_m(kind);
        constants.estimate.maps[index_of(kind)] = {maps.cut_cells(index_of(kind), radius_m), radius_m, 2};
    }
}

/// The pilots where they are missing, the maps one after another, and then the image.
void ProgressiveMappingGpu::State::add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    begin_pass(pass);
    steps.push_back({0, [this, pass](gpu::CommandList& commands) {
                         commands.update(
                             sampler,
                             PassSampler(params.sampler, context.seed, RandomDomain::Camera, pass).device_data());
                         commands.update(told, constants);
                     }});
    for (const PhotonMapKind kind : kPhotonMapKinds)
        if (!pilots_stand) add_photon_steps(pilot_of(kind), photons.pilot_seed(), 0, steps);
    for (const PhotonMapKind kind : kPhotonMapKinds) add_photon_steps(index_of(kind), context.seed, pass, steps);
    for (uint32_t piece = 0; piece * tiles_a_piece < tiles; ++piece)
        steps.push_back(
            {device.paths_per_submit(), [this, piece](gpu::CommandList& commands) { record_eye(piece, commands); }});
}

/// Each piece has a submit of its own.
void ProgressiveMappingGpu::State::add_photon_steps(size_t map, uint64_t seed, uint32_t pass,
                                                    DeviceFrame::Steps& steps) {
    for (uint32_t piece = 0; piece < maps.pieces(map); ++piece)
        steps.push_back({device.paths_per_submit(),
                         [=, this](gpu::CommandList& commands) { maps.record(commands, map, seed, pass, piece); }});
}

void ProgressiveMappingGpu::State::record_eye(uint32_t piece, gpu::CommandList& commands) {
    DeviceImage& image = frame.image();
    GridPhotons& found = maps.photons();
    const uint32_t first = piece * tiles_a_piece, end = std::min(first + tiles_a_piece, tiles);
    {
        const gpu::Scope scope(commands, "gather");
        commands.bind(
            *eye_pass,
            {gpu::read_write("device_layers", image.layers()), gpu::read_write("device_counters", image.counters()),
             gpu::read("eye", eye), gpu::read("pass_sampler", sampler), gpu::read("constants", told),
             gpu::read("grid_starts", found.starts), gpu::read("grid_places", found.places),
             gpu::read("map_powers", found.powers), gpu::read("radius_maps", radius_maps),
             gpu::read("points_before", points_before()), gpu::write("points_after", points_after())});
        commands.push(gpu::ProgressivePush{first, end});
        commands.dispatch_threads(uint64_t{end - first} * kEyeTilePixels, kEyeTilePixels);
    }
    if (end < tiles) return;
    image.record_readback(commands);
    if (points) points->record_readback(commands);
}

/// Of a whole pass: true where there was too little room for photons. Now there is.
bool ProgressiveMappingGpu::State::grow_if_short() {
    if (!maps.is_short()) return false;
    make_room();
    return true;
}

void ProgressiveMappingGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    const StageTimer timer(stats, "gather");
    if (!state.frame.run_with_room(pass, stats, cancel, [&] { return state.grow_if_short(); })) return;
    if (state.points) state.points->end_pass();
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        if (!state.wanted(kind)) continue;
        state.maps.add_to(stats.counts, index_of(kind));
        if (state.pilots_stand || !state.maps.has(pilot_of(kind))) continue;
        Counts of_pilot;  // no part of the image
        state.maps.add_to(of_pilot, pilot_of(kind));
        stats.counts.photon_rays += of_pilot.photon_rays;
    }
    state.pilots_stand = true;
}

PassImage* ProgressiveMappingGpu::end_pass() {
    if (state_->points) state_->points->resolve();
    return DeviceMethod::end_pass();
}

std::string ProgressiveMappingGpu::state() const {
    if (params_->passes_stand_alone()) return {};
    if (!state_) return state_before_;
    return state_->photons.any() ? state_->points->state() : kNoPoints;
}

DeviceFrame& ProgressiveMappingGpu::frame() { return state_->frame; }

}  // namespace photond
