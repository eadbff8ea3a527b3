#include "renderer/methods/photon_mapping/photon_mapping_gpu.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "protocol/error.h"
#include "renderer/eye/eye_constants.h"
#include "renderer/frame/device_frame.h"
#include "renderer/gathering/gathering_shared.h"
#include "renderer/gathering/photon_plan.h"
#include "renderer/photons/disc_coverage.h"
#include "renderer/photons/photon_guides.h"
#include "renderer/photons/photon_maps_gpu.h"
#include "renderer/photons/surface_edges.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

namespace {

constexpr std::array kKinds{PhotonMapKind::Global, PhotonMapKind::Caustic};
constexpr size_t index_of(PhotonMapKind kind) { return static_cast<size_t>(kind); }

uint32_t paths_of(const PhotonMappingParams& params, PhotonMapKind kind) {
    return kind == PhotonMapKind::Global ? params.photons : params.caustic_photons.value_or(params.photons);
}

/// How many photons a map is laid out for, whatever it then stores: its order must be the same in each pass.
uint64_t expected_photons(const PhotonMappingParams& params, PhotonMapKind kind) {
    return static_cast<uint64_t>(yield_of(kExpectedPhotonYield, kind).unguided * paths_of(params, kind)) + 1;
}

uint32_t nearest_of(const PhotonMappingParams& params, PhotonMapKind kind) {
    if (kind == PhotonMapKind::Global) return params.nearest_photons;
    return params.caustic_nearest_photons.value_or(params.nearest_photons);
}

/// By what the cells of a map are cut: the radius, or what a search for the k nearest begins with.
float cell_size_m(const PhotonMappingParams& params, PhotonMapKind kind, const Bounds3& bounds, float radius_m) {
    if (params.search == PhotonSearch::Kind::Radius) return radius_m;
    return cell_for_nearest(bounds, kind, expected_photons(params, kind), nearest_of(params, kind), radius_m);
}

uint32_t paths_a_pixel(const Splits& splits) { return splits.light_samples + splits.gather_rays; }

uint64_t split_bytes(const Splits& splits) {
    return uint64_t{paths_a_pixel(splits)} * SPLIT_PREPARED_SETS * 2 * sizeof(uint32_t);
}

/// Room for points that gather, of a piece: about one a pixel; a few more where a path may leave several.
uint64_t points_of_piece(uint32_t tiles, bool only_lambert) {
    const uint64_t pixels = uint64_t{tiles} * kEyeTilePixels;
    return only_lambert ? pixels : pixels + pixels / 4;
}
constexpr uint32_t kGatherLanes = 8;           // threads of a point
constexpr uint32_t kSoftwareGatherLanes = 64;  // lavapipe leaves the loops of a thread after 65535 turns in all
constexpr uint64_t kPointBytes = sizeof(gpu::GatherPointRecord) + kGatherLanes * sizeof(gpu::GatheredRecord);

uint32_t tiles_of_piece(uint32_t paths_per_submit, uint32_t tiles, const Splits& splits) {
    return std::clamp(paths_per_submit / (kEyeTilePixels * paths_a_pixel(splits)), 1u, std::max(tiles, 1u));
}

uint64_t last_points_bytes(const PhotonMappingParams& params, uint32_t tiles_a_piece) {
    const uint64_t pixels = params.gather == Gather::Final ? uint64_t{tiles_a_piece} * kEyeTilePixels : 1;
    return pixels * sizeof(uint32_t);
}

}  // namespace

struct PhotonMappingGpu::State {
    State(const RenderContext& context, const PhotonMappingParams& parameters)
        : params(parameters),
          on_device(*context.device_scene),
          device(on_device.device()),
          scene(context.scene),
          size(context.view.film_size),
          splits(params.splits(size.pixels())),
          seed(context.seed),
          search_radius_m(parameters.search_radius_m(context.scene.bounds.radius())),
          tiles(eye_tile_count(size)),
          tiles_a_piece(tiles_of_piece(device.paths_per_submit(), tiles, splits)),
          edges(parameters.boundary == DiscBoundary::Clip
                    ? std::optional<EdgeTree>(std::in_place, find_surface_edges(scene, search_radius_m))
                    : std::nullopt),
          eye(device, "eye", sizeof(gpu::EyeConstants)),
          mapping(device, "photon_mapping", sizeof(gpu::GatheringConstants)),
          split_samplers(device, "renderer/methods/photon_mapping/split_samplers.comp", sizeof(gpu::SplitSamplersPush),
                         &on_device.set()),
          maps(on_device),
          sampler(device, "sampler", sizeof(gpu::PassSamplerData)),
          split_points(device, "split_samplers", split_bytes(splits)),
          host_point_state(device, "readback", POINT_STATE_WORDS * sizeof(uint32_t), gpu::MemoryKind::Readback),
          frame(context, [this](uint32_t pass, DeviceFrame::Steps& steps) { add_steps(pass, steps); }) {
        const gpu::EyeConstants constants = make_eye_constants(context.view, params.max_scatterings(), ROULETTE_START);
        gpu::upload(device, eye, std::as_bytes(std::span(&constants, 1)));
    }

    void add_map(PhotonMapKind kind, uint32_t most_scatterings, const ProjectionMap* guide);
    void make_room();
    void prepare_passes(bool lights_can_be_met, uint32_t irradiance_scatterings);
    void add_steps(uint32_t pass, DeviceFrame::Steps& steps);
    void record_samplers(uint32_t pass, gpu::CommandList& commands);
    void record_photons(uint32_t pass, PhotonMapKind kind, uint32_t piece, gpu::CommandList& commands);
    void record_irradiance(gpu::CommandList& commands);
    void record_eye(uint32_t piece, gpu::CommandList& commands);
    void record_gather(uint32_t first_tile, uint32_t end_tile, gpu::CommandList& commands);
    bool gathers() const { return params.gather == Gather::Final; }
    bool precomputes() const { return constants.irradiance_scatterings > 0; }
    bool grow_if_short();

    const PhotonMappingParams params;
    const gpu::DeviceScene& on_device;
    gpu::Device& device;
    const Scene& scene;
    const Size2 size;
    const Splits splits;
    const uint64_t seed;
    const float search_radius_m;
    const uint32_t tiles, tiles_a_piece;
    const std::optional<EdgeTree> edges;
    gpu::Buffer eye, mapping;
    gpu::ComputePipeline split_samplers;
    std::optional<gpu::ComputePipeline> precompute, eye_pass, gather_pass, gather_sum;
    PhotonMapsGpu maps;  // by kind
    const uint32_t gather_lanes = device.report().software ? kSoftwareGatherLanes : kGatherLanes;
    uint64_t point_capacity = 1;
    // Points that gather, of a piece: their state, themselves, what they gathered, and each pixel's last one.
    gpu::Buffer point_state, points, gathered, last_points;
    gpu::GatheringConstants constants{};
    gpu::Buffer sampler, split_points;
    gpu::Buffer host_point_state;
    DeviceFrame frame;  // last: its going waits for work that uses the others
};

PhotonMappingGpu::PhotonMappingGpu(const PhotonMappingParams& params) : params_(params) {}
PhotonMappingGpu::~PhotonMappingGpu() = default;

void PhotonMappingGpu::check_gpu(const PhotonMappingParams& params) {
    const auto refuse = [](bool asked, const char* pointer, const char* what) {
        if (asked) throw Error(ErrorCode::Unsupported, pointer, std::string(what) + " on a GPU; the CPU has it");
    };
    refuse(params.shadow_photons, "/shadow_photons", "there are no shadow photons");
    refuse(params.gather_sampling == GatherSampling::Photons, "/gather_sampling",
           "gather rays are not drawn by the photons");
    refuse(params.keep_photon_map, "/keep_photon_map", "photons are not kept");
}

uint64_t PhotonMappingGpu::estimate_bytes(const PhotonMappingParams& /*params*/, const Workload& workload) {
    return DeviceFrame::estimate_bytes(workload);
}

uint64_t PhotonMappingGpu::estimate_device_bytes(const PhotonMappingParams& params, const Workload& workload) {
    const PhotonYield yield = workload.photon_yield.value_or(kExpectedPhotonYield);
    const PhotonPlan plan = plan_of(params, workload);
    const Splits splits = params.splits(workload.film_size.pixels());
    uint64_t bytes = DeviceFrame::estimate_device_bytes(workload) + sizeof(gpu::PassSamplerData) + split_bytes(splits) +
                     sizeof(gpu::EyeConstants) + sizeof(gpu::GatheringConstants);
    if (params.boundary == DiscBoundary::Clip) bytes += EdgeTree::estimate_bytes(workload.triangles);
    if (params.gather == Gather::Final) {  // what is a piece differs from device to device: the largest
        const uint64_t pixels = workload.film_size.pixels();
        const bool only_lambert = workload.needs.only_lambert();
        const auto film_tiles = static_cast<uint32_t>((pixels + kEyeTilePixels - 1) / kEyeTilePixels);
        const uint32_t most_tiles = tiles_of_piece(gpu::Device::kMostPathsPerSubmit, film_tiles, splits);
        bytes += points_of_piece(most_tiles, only_lambert) * kPointBytes + last_points_bytes(params, most_tiles);
    }
    uint64_t most = 0;
    for (const PhotonMapKind kind : kKinds) {
        const bool global = kind == PhotonMapKind::Global;
        if (!(global ? plan.global : plan.caustic).wanted()) continue;
        const double measured = yield_of(yield, kind).by(params.projection_maps);
        const uint64_t expected = expected_photons(params, kind);
        const uint64_t capacity =
            PhotonMapsGpu::room_for(std::max(measured * paths_of(params, kind), static_cast<double>(expected)));
        most = std::max(most, capacity);
        const bool precomputes = global && plan.irradiance_scatterings > 0;
        bytes += PhotonMapsGpu::map_bytes(expected, capacity, precomputes ? capacity : 0);
        if (params.projection_maps) bytes += estimate_guide_bytes(kind, workload);
    }
    return bytes + PhotonMapsGpu::shared_bytes(most);
}

void PhotonMappingGpu::State::add_map(PhotonMapKind kind, uint32_t most_scatterings, const ProjectionMap* guide) {
    maps.add(index_of(kind),
             PhotonTracing{.kind = kind,
                           .photons = paths_of(params, kind),
                           .most_scatterings = most_scatterings,
                           .glossy_threshold = params.glossy_threshold,
                           .sampler = params.sampler,
                           .guide = guide},
             expected_photons(params, kind));
}

/// For as many photons as the maps say, and for as many points that gather as is said.
void PhotonMappingGpu::State::make_room() {
    // Behind the grids' own words: shaders may bind no more buffers.
    const std::vector<uint32_t> words = edges ? edges->device_words() : std::vector<uint32_t>();
    maps.make_room(words, precomputes() ? maps.room(PHOTON_MAP_GLOBAL) : 0);
    constants.estimate.first_irradiance = maps.first_record();
    if (edges) constants.estimate.coverage = edges->device_constants(maps.first_word());
    points = {}, gathered = {};
    points = gpu::Buffer(device, "gather_points", point_capacity * sizeof(gpu::GatherPointRecord));
    gathered = gpu::Buffer(device, "gather_points", point_capacity * gather_lanes * sizeof(gpu::GatheredRecord));
    for (const PhotonMapKind kind : kKinds) {
        const float cell_m = cell_size_m(params, kind, scene.bounds, search_radius_m);
        constants.estimate.maps[index_of(kind)] = {maps.cut_cells(index_of(kind), cell_m), search_radius_m,
                                                   nearest_of(params, kind)};
    }
    gpu::upload(device, mapping, std::as_bytes(std::span(&constants, 1)));
}

void PhotonMappingGpu::State::prepare_passes(bool lights_can_be_met, uint32_t irradiance_scatterings) {
    constants = {.estimate = {.kernel = Kernel(params.kernel, params.cone_k).device_record(),
                              .disc_thickness_m = params.disc_thickness_m.value_or(-1.0f),
                              .coverage = {},
                              .first_irradiance = 0},
                 .glossy_threshold = params.glossy_threshold,
                 .light_samples = splits.light_samples,
                 .gather_rays = splits.gather_rays,
                 .lights_can_be_met = lights_can_be_met,
                 .irradiance_scatterings = irradiance_scatterings};
    if (gathers()) point_capacity = points_of_piece(tiles_a_piece, scene.needs.only_lambert());
    point_state = gpu::Buffer(device, "gather_points", POINT_STATE_WORDS * sizeof(uint32_t));
    last_points = gpu::Buffer(device, "gather_points", last_points_bytes(params, tiles_a_piece));
    make_room();
    std::vector<gpu::Specialization> fixed{
        gpu::specialize(SEARCH_NEAREST_ID, params.search == PhotonSearch::Kind::Nearest),
        gpu::specialize(SOFT_DISC_ID, params.soft_disc),
        gpu::specialize(DISC_COVERAGE_ID, edges.has_value()),
        gpu::specialize(FINAL_GATHER_ID, gathers()),
        gpu::specialize(GATHER_LANES_ID, gather_lanes),
        gpu::specialize(GLOBAL_MAP_ID, maps.has(PHOTON_MAP_GLOBAL)),
        gpu::specialize(CAUSTIC_MAP_ID, maps.has(PHOTON_MAP_CAUSTIC)),
        gpu::specialize(PRECOMPUTED_IRRADIANCE_ID, precomputes())};
    fixed = on_device.specialization(fixed);
    if (precomputes())
        precompute.emplace(device, "renderer/photons/precomputed_irradiance.comp", sizeof(gpu::PrecomputePush),
                           &on_device.set(), fixed);
    eye_pass.emplace(device, "renderer/methods/photon_mapping/photon_mapping.comp", sizeof(gpu::EyePassPush),
                     &on_device.set(), fixed);
    if (gathers()) {
        gather_pass.emplace(device, "renderer/methods/photon_mapping/photon_gather.comp", sizeof(gpu::GatherPush),
                            &on_device.set(), fixed);
        gather_sum.emplace(device, "renderer/methods/photon_mapping/photon_gather_sum.comp", sizeof(gpu::GatherSumPush),
                           &on_device.set(), fixed);
    }
}

/// The maps one after another, and then the image.
void PhotonMappingGpu::State::add_steps(uint32_t pass, DeviceFrame::Steps& steps) {
    const uint64_t whole_submit = device.paths_per_submit();  // each piece has one of its own
    steps.push_back({0, [=, this](gpu::CommandList& commands) { record_samplers(pass, commands); }});
    for (const PhotonMapKind kind : kKinds)
        for (uint32_t piece = 0; piece < maps.pieces(index_of(kind)); ++piece)
            steps.push_back(
                {whole_submit, [=, this](gpu::CommandList& commands) { record_photons(pass, kind, piece, commands); }});
    for (uint32_t piece = 0; piece * tiles_a_piece < tiles; ++piece)
        steps.push_back({whole_submit, [=, this](gpu::CommandList& commands) { record_eye(piece, commands); }});
}

void PhotonMappingGpu::State::record_samplers(uint32_t pass, gpu::CommandList& commands) {
    commands.update(sampler, PassSampler(params.sampler, seed, RandomDomain::Camera, pass).device_data());
    const gpu::SplitSamplersPush split{splits.light_samples, splits.gather_rays};
    commands.bind(split_samplers, {gpu::read("pass_sampler", sampler), gpu::write("points", split_points)});
    commands.push(split);
    commands.dispatch_threads(uint64_t{paths_a_pixel(splits)} * SPLIT_PREPARED_SETS, SPLIT_SAMPLERS_GROUP);
}

/// Some of a map's light paths; with the last of them it is built.
void PhotonMappingGpu::State::record_photons(uint32_t pass, PhotonMapKind kind, uint32_t piece,
                                             gpu::CommandList& commands) {
    if (!maps.record(commands, index_of(kind), seed, pass, piece)) return;
    if (kind == PhotonMapKind::Global && precomputes()) record_irradiance(commands);
}

/// At the global map's marked photons.
void PhotonMappingGpu::State::record_irradiance(gpu::CommandList& commands) {
    const gpu::Scope scope(commands, "photon_map_build");
    commands.bind(*precompute,
                  {gpu::read("grid_starts", maps.photons().starts), gpu::read("grid_places", maps.photons().places),
                   gpu::read("map_powers", maps.photons().powers), gpu::read("estimate_constants", mapping),
                   gpu::write("irradiances", maps.photons().powers)});
    commands.push(gpu::PrecomputePush{constants.irradiance_scatterings});
    const uint64_t groups = (maps.room(PHOTON_MAP_GLOBAL) + PRECOMPUTE_PHOTONS - 1) / PRECOMPUTE_PHOTONS;
    commands.dispatch_threads(groups * PRECOMPUTE_GROUP, PRECOMPUTE_GROUP);
}

void PhotonMappingGpu::State::record_eye(uint32_t piece, gpu::CommandList& commands) {
    DeviceImage& image = frame.image();
    const uint32_t first = piece * tiles_a_piece, end = std::min(first + tiles_a_piece, tiles);
    {
        const gpu::Scope scope(commands, gathers() ? "direct" : "gather");
        if (gathers()) commands.fill(point_state, 0, POINTS_WORD * sizeof(uint32_t), sizeof(uint32_t));
        if (piece == 0) commands.fill(point_state, 0);
        commands.bind(
            *eye_pass,
            {gpu::read_write("device_layers", image.layers()), gpu::read_write("device_counters", image.counters()),
             gpu::read("eye", eye), gpu::read("pass_sampler", sampler), gpu::read("split_points", split_points),
             gpu::read("mapping", mapping), gpu::read("grid_starts", maps.photons().starts),
             gpu::read("grid_places", maps.photons().places), gpu::read("map_powers", maps.photons().powers),
             gpu::read_write("point_state", point_state), gpu::write("points", points),
             gpu::write("last_points", last_points)});
        commands.push(gpu::EyePassPush{first, end, static_cast<uint32_t>(point_capacity)});
        commands.dispatch_threads(uint64_t{end - first} * kEyeTilePixels, kEyeTilePixels);
    }
    if (gathers()) record_gather(first, end, commands);
    if (end < tiles) return;
    image.record_readback(commands);
    commands.copy(point_state, 0, host_point_state, 0, point_state.bytes());
    commands.host_reads(host_point_state);
}

/// The rays of a piece's points.
void PhotonMappingGpu::State::record_gather(uint32_t first_tile, uint32_t end_tile, gpu::CommandList& commands) {
    DeviceImage& image = frame.image();
    const gpu::Scope scope(commands, "gather");
    commands.bind(
        *gather_pass,
        {gpu::read_write("device_layers", image.layers()), gpu::read_write("device_counters", image.counters()),
         gpu::read("eye", eye), gpu::read("pass_sampler", sampler), gpu::read("split_points", split_points),
         gpu::read("mapping", mapping), gpu::read("grid_starts", maps.photons().starts),
         gpu::read("grid_places", maps.photons().places), gpu::read("map_powers", maps.photons().powers),
         gpu::read("point_state", point_state), gpu::read("points", points), gpu::write("gathered_light", gathered)});
    commands.push(gpu::GatherPush{static_cast<uint32_t>(point_capacity)});
    commands.dispatch_threads(point_capacity * gather_lanes, GATHER_GROUP);
    commands.bind(*gather_sum, {gpu::read_write("device_layers", image.layers()), gpu::read("eye", eye),
                                gpu::read("pass_sampler", sampler), gpu::read_write("point_state", point_state),
                                gpu::read("points", points), gpu::read("gathered_light", gathered),
                                gpu::read("last_points", last_points)});
    commands.push(gpu::GatherSumPush{first_tile, end_tile});
    commands.dispatch_threads(uint64_t{end_tile - first_tile} * kEyeTilePixels, kEyeTilePixels);
}

/// Of a whole pass: true where there was too little room for photons, or for points that gather. Now there is.
bool PhotonMappingGpu::State::grow_if_short() {
    bool short_of_room = maps.is_short();
    if (const uint64_t most = host_point_state.as<const uint32_t>()[MOST_POINTS_WORD]; most > point_capacity) {
        point_capacity = most + most / 4;
        short_of_room = true;
    }
    if (short_of_room) make_room();
    return short_of_room;
}

void PhotonMappingGpu::begin(const RenderContext& context, Stats& stats) {
    check_gpu(params_);
    const Scene& scene = context.scene;
    state_ = std::make_unique<State>(context, params_);
    State& state = *state_;

    // On the host for as long as the projection maps are being made.
    std::optional<EmissionSampler> emission;
    make_emission(scene, emission, stats);
    const PhotonPlan plan(params_, context.view.film_size.pixels(), emission.has_value(),
                          has_specular_surface(scene, params_.glossy_threshold));
    const auto skip_map = [&](const char* what, PhotonMapKind kind, const std::string& why) {
        const uint64_t expected = expected_photons(params_, kind);
        const uint64_t room = PhotonMapsGpu::room_for(static_cast<double>(expected));
        stats.skipped.push_back(
            {what, why, PhotonMapsGpu::shared_bytes(room) + PhotonMapsGpu::map_bytes(expected, room)});
    };
    if (!plan.global.wanted()) skip_map("global map", PhotonMapKind::Global, plan.global.why_not);
    if (!plan.caustic.wanted()) skip_map("caustic map", PhotonMapKind::Caustic, plan.caustic.why_not);
    if (const char* why = plan.why_not_precomputed(params_)) {
        const uint64_t room =
            PhotonMapsGpu::room_for(static_cast<double>(expected_photons(params_, PhotonMapKind::Global)));
        stats.skipped.push_back({"precomputed irradiance", why, room * sizeof(gpu::PhotonPower)});
    }
    if (!scene.needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});

    PhotonGuides guides;  // which the device copies
    const auto add_map = [&](PhotonMapKind kind, const auto& wanted) {
        if (!wanted.wanted()) return;
        if (params_.projection_maps)
            guides.add(kind, scene, *context.intersector, *emission, params_.glossy_threshold, context.seed,
                       context.budget, stats);
        state.add_map(kind, wanted.most_scatterings, guides.of(kind));
    };
    add_map(PhotonMapKind::Global, plan.global);
    add_map(PhotonMapKind::Caustic, plan.caustic);
    state.prepare_passes(!scene.triangle_lights.empty() || scene.environment.has_value(), plan.irradiance_scatterings);
}

void PhotonMappingGpu::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    const StageTimer timer(stats, "gather");
    if (!state.frame.run_with_room(pass, stats, cancel, [&] { return state.grow_if_short(); })) return;
    for (const PhotonMapKind kind : kKinds)
        if (state.maps.has(index_of(kind))) state.maps.add_to(stats.counts, index_of(kind));
}

DeviceFrame& PhotonMappingGpu::frame() { return state_->frame; }

}  // namespace photond
