#include "renderer/bidirectional/light_paths_gpu.h"

#include <algorithm>
#include <bit>

#include "protocol/error.h"
#include "renderer/eye/eye_shared.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

static_assert(1u << LIGHT_RUN_BITS == SequenceSampler::kRun);

constexpr uint32_t kMostSurfaceBits = 8;        // of a key; paths with more surfaces are sorted by their path alone
constexpr uint32_t kMostLightPaths = 1u << 28;  // so that some are left
/// Pixels about the image whose splats its own pixels see: those that a filter reaches from.
constexpr uint32_t kSplatMargin = 2;
static_assert(FILTER_RADIUS - 0.5f < kSplatMargin);

uint64_t vertex_room_for(double vertices) { return static_cast<uint64_t>(kLightVertexMargin * vertices) + 64; }

/// A cell a pixel, the margin about the image included, and a last column for what is not seen.
gpu::HashGridConstants splat_cells(Size2 size) {
    gpu::HashGridConstants grid{};
    grid.origin = vec3(-static_cast<float>(kSplatMargin), -static_cast<float>(kSplatMargin), 0);
    grid.cell_m = 1;
    grid.cells_per_m = vec3(1);
    grid.cells = {static_cast<int>(size.width + 2 * kSplatMargin + 1), static_cast<int>(size.height + 2 * kSplatMargin),
                  1};
    grid.slots = static_cast<uint32_t>(grid.cells.x) * static_cast<uint32_t>(grid.cells.y);
    return grid;
}

constexpr uint64_t kBytesOfVertex = sizeof(gpu::LightVertexRecord) + sizeof(gpu::LightSplatRecord) +
                                    2 * sizeof(gpu::PhotonPlace) + 3 * sizeof(uint32_t);
constexpr uint64_t kSortBytesOfVertex = 2 * sizeof(uint32_t);  // of an element

/// Words of the tables over the vertices.
uint64_t vertex_table_words(uint64_t expected, bool merges, bool own_path, uint32_t paths) {
    return 1 + (merges ? grid_starts_for(expected) : 0) + (own_path ? uint64_t{paths} + 1 : 0);
}

}  // namespace

LightPathsGpu::LightPathsGpu(const gpu::DeviceScene& scene, const BidirectionalPlan& plan, SamplerKind sampler,
                             uint64_t seed, Size2 film_size, std::span<const gpu::Specialization> constants)
    : scene_(scene),
      device_(scene.device()),
      plan_(plan.techniques),
      film_size_(film_size),
      sampler_(sampler, seed, RandomDomain::LightPaths, 0),
      seed_(seed),
      expected_(static_cast<uint64_t>(plan.vertices_per_path * plan.techniques.light_paths) + 1),
      edge_words_(plan.coverage && plan.techniques.everywhere.numbers.merges ? plan.coverage->edges().device_words()
                                                                             : std::vector<uint32_t>()),
      splat_grid_(splat_cells(film_size)),
      hash_grid_(device_),
      trace_(device_, "renderer/bidirectional/light_paths.comp", sizeof(gpu::LightPathsPush), &scene.set(), constants),
      place_(device_, "renderer/bidirectional/light_vertex_places.comp", sizeof(gpu::HashGridConstants)),
      show_(device_, "renderer/bidirectional/light_image.comp", sizeof(gpu::LightImagePush), &scene.set(), constants),
      techniques_(device_, "light_paths", sizeof(gpu::BidirectionalConstants)),
      state_(device_, "light_paths", LIGHT_STATE_WORDS * sizeof(uint32_t)),
      host_state_(device_, "readback", LIGHT_STATE_WORDS * sizeof(uint32_t), gpu::MemoryKind::Readback),
      splat_starts_(device_, "light_image", (uint64_t{splat_grid_.slots} + 1) * sizeof(uint32_t)) {
    if (plan_.light_paths > kMostLightPaths)
        throw Error(ErrorCode::OutOfMemory, std::to_string(plan_.light_paths) + " light paths are more than the " +
                                                std::to_string(kMostLightPaths) + " that can be sorted");
    const uint32_t first_edge = static_cast<uint32_t>(
        vertex_table_words(expected_, plan_.everywhere.numbers.merges, plan_.own_path, plan_.light_paths));
    if (!edge_words_.empty()) constants_.edges = plan.coverage->edges().device_constants(first_edge);
    make_room(vertex_room_for(static_cast<double>(expected_)));
}

uint64_t LightPathsGpu::device_bytes(uint32_t paths, double vertices_per_path, bool merges, bool own_path,
                                     Size2 film_size) {
    const uint64_t expected = static_cast<uint64_t>(vertices_per_path * paths) + 1;
    return vertex_room_for(static_cast<double>(expected)) * (kBytesOfVertex + kSortBytesOfVertex) +
           (vertex_table_words(expected, merges, own_path, paths) + splat_cells(film_size).slots) * sizeof(uint32_t) +
           (merges ? vertex_room_for(static_cast<double>(expected)) * sizeof(gpu::PhotonPlace) : 0);
}

void LightPathsGpu::make_room(uint64_t vertices) {
    if (vertices > uint64_t{1} << 31)
        throw Error(ErrorCode::OutOfMemory, "light paths leave " + std::to_string(vertices) +
                                                " vertices, and at most 2147483648 can be sorted");
    const auto capacity = static_cast<uint32_t>(vertices);
    // Not both at once.
    sort_.reset(), tables_.reset(), vertices_.reset(), places_.reset(), keys_.reset(), order_.reset();
    grid_places_.reset(), splat_places_.reset(), splats_.reset(), splat_order_.reset();
    const auto make = [&](std::optional<gpu::Buffer>& buffer, const char* structure, uint64_t bytes_of_one) {
        buffer.emplace(device_, structure, vertices * bytes_of_one);
    };
    sort_.emplace(device_, capacity);
    const uint64_t words =
        vertex_table_words(expected_, plan_.everywhere.numbers.merges, plan_.own_path, plan_.light_paths);
    tables_.emplace(device_, "photon_maps", (words + edge_words_.size()) * sizeof(uint32_t));
    if (!edge_words_.empty())
        gpu::upload(device_, *tables_, std::as_bytes(std::span(edge_words_)), words * sizeof(uint32_t));
    make(vertices_, "light_vertices", sizeof(gpu::LightVertexRecord));
    make(places_, "light_vertices", sizeof(gpu::PhotonPlace));
    make(keys_, "light_vertices", sizeof(uint32_t));
    make(order_, "light_vertices", sizeof(uint32_t));
    make(splat_places_, "light_image", sizeof(gpu::PhotonPlace));
    make(splats_, "light_image", sizeof(gpu::LightSplatRecord));
    make(splat_order_, "light_image", sizeof(uint32_t));
    grid_places_.emplace(device_, "photon_maps",
                         (plan_.everywhere.numbers.merges ? vertices : 1) * sizeof(gpu::PhotonPlace));
    constants_.capacity = splat_grid_.capacity = capacity;
    // A pass with too little room is made of whatever stands here, and made again.
    gpu::CommandList commands(device_);
    for (gpu::Buffer* buffer : {&*order_, &*splat_order_}) commands.fill(*buffer, 0);
    commands.submit();
    commands.wait();
}

uint32_t LightPathsGpu::begin_pass(uint32_t pass, const PassTechniques& techniques) {
    pass_ = pass;
    constants_.join_salt = hash64(seed_) + pass;
    const TechniqueNumbers& numbers = techniques.everywhere.numbers;
    constants_.numbers = {numbers.light_paths, numbers.connections, numbers.merges, numbers.caustic_radius};
    constants_.light_paths = techniques.light_paths;
    constants_.connections_per_vertex = techniques.everywhere.connections_per_vertex;
    constants_.own_path = techniques.own_path;
    constants_.merge_radius_m = techniques.merge_radius_m;
    constants_.edge_radius_m = techniques.edge_radius_m;
    constants_.first_of_paths = 1;
    if (numbers.merges) {
        constants_.vertex_grid = lay_out_grid(scene_.scene().bounds, techniques.merge_radius_m, expected_);
        constants_.vertex_grid.first_start = 1;
        constants_.first_of_paths += static_cast<uint32_t>(grid_starts_for(expected_));
    }
    constants_.vertex_grid.capacity = constants_.capacity;
    const uint32_t most = device_.paths_per_submit();
    return (plan_.light_paths + most - 1) / most;
}

void LightPathsGpu::record_start(gpu::CommandList& commands) {
    commands.update(techniques_, constants_);
    commands.fill(state_, 0);
}

void LightPathsGpu::record_paths(gpu::CommandList& commands, gpu::Buffer& eye, uint32_t piece) {
    const gpu::Scope scope(commands, "light_paths");
    const uint32_t most = device_.paths_per_submit(), first = piece * most;
    const uint32_t end = plan_.light_paths - first > most ? first + most : plan_.light_paths;
    const uint32_t threads = std::min(end - first, kMostPathThreads);
    commands.fill(state_, 0, LIGHT_NEXT_PATH_WORD * sizeof(uint32_t), sizeof(uint32_t));
    commands.bind(trace_,
                  {gpu::read("eye", eye), gpu::read("techniques", techniques_), gpu::read("grid_starts", *tables_),
                   gpu::read_write("state", state_), gpu::write("places", *places_), gpu::write("vertices", *vertices_),
                   gpu::write("keys", *keys_), gpu::write("order", *order_), gpu::write("splat_places", *splat_places_),
                   gpu::write("splats", *splats_)});
    const uint32_t runs =
        static_cast<uint32_t>(SequenceRuns{first_element(), first_element() + plan_.light_paths}.count());
    commands.push(gpu::LightPathsPush{
        .sequence = sampler_.device_key(),
        .first_element = first_element(),
        .first_path = first,
        .end_path = end,
        .surface_bits = plan_.own_path ? 0 : std::min(kMostSurfaceBits, 32 - LIGHT_RUN_BITS - key_bits_of(runs)),
        .threads = threads});
    commands.dispatch_threads(threads, LIGHT_PATHS_GROUP);
}

void LightPathsGpu::record_order(gpu::CommandList& commands) {
    const gpu::Scope scope(commands, "photon_map_build");
    const uint64_t order_bytes = order_->bytes();
    sort_->record(commands, *keys_, *order_, state_, plan_.own_path ? key_bits_of(plan_.light_paths) : 32);
    if (plan_.own_path) {
        gpu::HashGridConstants by_path{};
        by_path.slots = plan_.light_paths;
        by_path.first_start = constants_.first_of_paths;
        by_path.capacity = constants_.capacity;
        hash_grid_.record_starts(commands, by_path, state_, *keys_, *tables_);
    }
    if (plan_.everywhere.numbers.merges) {
        commands.copy(*order_, 0, *splat_order_, 0, order_bytes);
        hash_grid_.record_cells(commands, constants_.vertex_grid, {state_, *places_, *keys_, *splat_order_, *sort_},
                                *tables_);
        commands.bind(place_, {gpu::read("count", state_), gpu::read("order", *splat_order_),
                               gpu::read("places", *places_), gpu::write("grid_places", *grid_places_)});
        commands.push(constants_.vertex_grid);
        commands.dispatch_threads(constants_.capacity, HASH_GRID_GROUP);
    }
    commands.copy(*order_, 0, *splat_order_, 0, order_bytes);
    hash_grid_.record_cells(commands, splat_grid_, {state_, *splat_places_, *keys_, *splat_order_, *sort_},
                            splat_starts_);
    commands.copy(state_, LIGHT_VERTICES_WORD * sizeof(uint32_t), *tables_, 0, sizeof(uint32_t));
    commands.copy(state_, 0, host_state_, 0, state_.bytes());
    commands.host_reads(host_state_);
}

void LightPathsGpu::record_image(gpu::CommandList& commands, DeviceImage& image, gpu::Buffer& eye) {
    const gpu::Scope scope(commands, "light_image");
    commands.bind(show_, {gpu::read_write("device_layers", image.layers()), gpu::read("eye", eye),
                          gpu::read("starts", splat_starts_), gpu::read("order", *splat_order_),
                          gpu::read("splat_places", *splat_places_), gpu::read("splats", *splats_)});
    commands.push(gpu::LightImagePush{static_cast<uint32_t>(splat_grid_.cells.x), kSplatMargin,
                                      shown_techniques(plan_.everywhere, film_size_)});
    commands.dispatch_threads(film_size_.pixels(), LIGHT_PATHS_GROUP);
}

bool LightPathsGpu::grow_if_short() {
    const uint32_t stored = host_state_.as<const uint32_t>()[LIGHT_VERTICES_WORD];
    if (stored <= constants_.capacity) return false;
    make_room(vertex_room_for(stored));
    return true;
}

void LightPathsGpu::add_to(Counts& counts) const {
    const std::span<const uint32_t> state = host_state_.as<const uint32_t>();
    const auto counted = [&](uint32_t word) { return uint64_t{state[word + 1]} << 32 | state[word]; };
    counts.photons_emitted += plan_.light_paths;
    counts.photons_stored += state[LIGHT_VERTICES_WORD];
    counts.photon_rays += counted(LIGHT_RAYS_WORD);
    counts.shadow_rays += counted(LIGHT_SHADOW_RAYS_WORD);
}

}  // namespace photond
