#include "renderer/photons/photon_maps_gpu.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "protocol/error.h"
#include "renderer/scene/scene.h"

namespace photond {

float cell_for_nearest(const Bounds3& bounds, PhotonMapKind kind, uint64_t photons, uint32_t nearest, float most_m) {
    if (bounds.empty()) return most_m;
    constexpr float kCausticShare = 1.0f / 32;  // of the walls
    constexpr float kBegin = 0.7f;              // of the disc
    constexpr float kMostCells = 16;            // along the farthest search
    const vec3 d = bounds.diagonal();
    const float walls_m2 =
        2 * (d.x * d.y + d.y * d.z + d.z * d.x) * (kind == PhotonMapKind::Caustic ? kCausticShare : 1);
    const float photons_per_m2 = static_cast<float>(photons) / walls_m2;
    const float disc_m = std::sqrt(static_cast<float>(nearest) / (std::numbers::pi_v<float> * photons_per_m2));
    const float least_m = std::min(most_m, 2 * bounds.radius()) / kMostCells;
    return std::clamp(kBegin * disc_m, std::min(least_m, most_m), most_m);
}

PhotonMapsGpu::PhotonMapsGpu(const gpu::DeviceScene& scene)
    : scene_(scene),
      device_(scene.device()),
      hash_grid_(device_),
      host_states_(device_, "readback", kMost * PhotonTracerGpu::kStateBytes, gpu::MemoryKind::Readback) {}

void PhotonMapsGpu::add(size_t map, const PhotonTracing& tracing, uint64_t expected, uint32_t bounce_map_texels) {
    maps_[map].tracer.emplace(scene_, tracing, bounce_map_texels);
    add_room(map, expected);
}

void PhotonMapsGpu::add_traced_on_host(size_t map, uint64_t expected) { add_room(map, expected); }

void PhotonMapsGpu::add_room(size_t map, uint64_t expected) {
    maps_[map].expected = expected;
    maps_[map].room = room_for(static_cast<double>(expected));
}

void PhotonMapsGpu::make_room(std::span<const uint32_t> words, uint64_t records) {
    unsorted_.reset(), grid_photons_.reset();  // not both at once
    uint64_t points = 0, most = 1, starts = 1;
    for (Map& map : maps_) {
        if (!map.expected) continue;
        map.upload.reset();
        if (map.room > uint64_t{1} << 31)
            throw Error(ErrorCode::OutOfMemory, "photons of one map are " + std::to_string(map.room) +
                                                    ", and at most 2147483648 can be sorted");
        map.grid.first_point = static_cast<uint32_t>(points);
        map.grid.first_start = static_cast<uint32_t>(starts);
        map.grid.capacity = static_cast<uint32_t>(map.room);
        points += map.room;
        most = std::max(most, map.room);
        starts += grid_starts_for(*map.expected);
    }
    points = std::max<uint64_t>(points, 1);
    if (points + records > UINT32_MAX)
        throw Error(ErrorCode::OutOfMemory, "the maps have " + std::to_string(points + records) +
                                                " records, and at most 4294967295 can be numbered");
    unsorted_.emplace(device_, static_cast<uint32_t>(most));
    grid_photons_.emplace(device_, starts + words.size(), points, records);
    for (Map& map : maps_)
        if (map.expected && !map.tracer) map.upload.emplace(device_, static_cast<uint32_t>(map.room));
    first_word_ = static_cast<uint32_t>(starts);
    first_record_ = static_cast<uint32_t>(points);
    if (!words.empty()) gpu::upload(device_, grid_photons_->starts, std::as_bytes(words), starts * sizeof(uint32_t));
}

const gpu::HashGridConstants& PhotonMapsGpu::cut_cells(size_t map, float cell_m) {
    gpu::HashGridConstants& grid = maps_[map].grid;
    gpu::HashGridConstants cut = lay_out_grid(scene_.scene().bounds, cell_m, *maps_[map].expected);
    cut.first_point = grid.first_point, cut.first_start = grid.first_start, cut.capacity = grid.capacity;
    return grid = cut;
}

uint32_t PhotonMapsGpu::pieces(size_t map) const {
    if (!has(map)) return 0;
    const std::optional<PhotonTracerGpu>& tracer = maps_[map].tracer;
    return tracer ? pieces_of(tracer->bounce_map_texels()) + pieces_of(tracer->tracing().photons) : 1;
}

bool PhotonMapsGpu::record(gpu::CommandList& commands, size_t map, uint64_t seed, uint32_t pass, uint32_t piece) {
    PhotonTracerGpu& tracer = *maps_[map].tracer;
    const gpu::HashGridConstants& grid = maps_[map].grid;
    const uint32_t paths = tracer.tracing().photons, texels = tracer.bounce_map_texels();
    const uint32_t most = device_.paths_per_submit(), texel_pieces = pieces_of(texels);
    if (piece == 0) tracer.record_start(commands);
    if (piece < texel_pieces) {
        const gpu::Scope scope(commands, "rsm");
        const uint32_t first = piece * most;
        tracer.record_bounce_map(commands, seed, pass, first, first + std::min(most, texels - first));
        return false;
    }
    const uint32_t first = (piece - texel_pieces) * most, end = paths - first > most ? first + most : paths;
    {
        const gpu::Scope scope(commands, "photon_tracing");
        tracer.record_paths(commands, seed, pass, first, end, *unsorted_, grid.capacity);
    }
    if (end < paths) return false;
    const gpu::Scope scope(commands, "photon_map_build");
    hash_grid_.record(commands, grid, tracer.state(), paths, *unsorted_, *grid_photons_);
    record_state(commands, map, tracer.state());
    return true;
}

void PhotonMapsGpu::record_traced_on_host(gpu::CommandList& commands, size_t map, std::span<const Photon> photons) {
    const gpu::Scope scope(commands, "photon_map_build");
    PhotonUploadGpu& upload = *maps_[map].upload;
    upload.record(commands, photons, *unsorted_);
    hash_grid_.record_ordered(commands, maps_[map].grid, upload.state(), *unsorted_, *grid_photons_);
    record_state(commands, map, upload.state());
}

void PhotonMapsGpu::record_state(gpu::CommandList& commands, size_t map, gpu::Buffer& state) {
    commands.copy(state, 0, host_states_, map * PhotonTracerGpu::kStateBytes, PhotonTracerGpu::kStateBytes);
    commands.host_reads(host_states_);
}

bool PhotonMapsGpu::is_short() {
    bool any = false;
    for (size_t map = 0; map < kMost; ++map) {
        if (!has(map)) continue;
        const uint64_t stored = state(map)[PHOTONS_STORED_WORD];
        if (stored <= maps_[map].room) continue;
        maps_[map].room = room_for(static_cast<double>(stored));
        any = true;
    }
    return any;
}

}  // namespace photond
