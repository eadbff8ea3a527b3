#include "renderer/photons/hash_grid_gpu.h"

#include <algorithm>
#include <bit>

namespace photond {

namespace {

// As hash_grid.cpp's.
constexpr float kRowsPerRadius = 0.99999f / 2;
constexpr float kCellsPerRadiusAlongX = 0.99999f;
constexpr float kMostCells = 0x1p20f;

uint64_t table_size(uint64_t points) { return std::bit_ceil(std::max<uint64_t>(points, 64)); }

}  // namespace

gpu::HashGridConstants lay_out_grid(const Bounds3& bounds, float cell_m, uint64_t points) {
    gpu::HashGridConstants grid{};
    grid.origin = bounds.empty() ? vec3(0) : bounds.min;
    grid.cell_m = cell_m;
    uint64_t cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const float extent = bounds.empty() ? 0.0f : bounds.max[axis] - bounds.min[axis];
        const float finest = kMostCells / extent;  // infinite for a flat box
        const float wanted = (axis == 0 ? kCellsPerRadiusAlongX : kRowsPerRadius) / cell_m;
        grid.cells_per_m[axis] = std::min({wanted, finest, std::numeric_limits<float>::max()});
        const float cells_along = extent * grid.cells_per_m[axis];
        grid.cells[axis] = (cells_along > 0 ? static_cast<int32_t>(std::min(cells_along, kMostCells)) : 0) + 1;
        cells *= static_cast<uint64_t>(grid.cells[axis]);
    }
    const uint64_t table = table_size(points);
    grid.hashed = cells > table;
    grid.slots = static_cast<uint32_t>(std::min(cells, table));
    return grid;
}

uint64_t grid_starts_for(uint64_t points) { return table_size(points) + 1; }

uint32_t key_bits_of(uint32_t values) { return std::max(static_cast<uint32_t>(std::bit_width(values - 1)), 1u); }

GridPhotons::GridPhotons(gpu::Device& device, uint64_t start_words, uint64_t capacity, uint64_t more)
    : starts(device, "photon_maps", start_words * sizeof(uint32_t)),
      places(device, "photon_maps", capacity * sizeof(gpu::PhotonPlace)),
      powers(device, "photon_maps", (capacity + more) * sizeof(gpu::PhotonPower)) {}

uint64_t GridPhotons::bytes_for(uint64_t starts, uint64_t capacity, uint64_t more) {
    return starts * sizeof(uint32_t) + capacity * sizeof(gpu::PhotonPlace) +
           (capacity + more) * sizeof(gpu::PhotonPower);
}

HashGridGpu::HashGridGpu(gpu::Device& device)
    : keys_(device, "renderer/photons/hash_grid_keys.comp", sizeof(gpu::HashGridConstants)),
      starts_(device, "renderer/photons/hash_grid_starts.comp", sizeof(gpu::HashGridConstants)),
      order_(device, "renderer/photons/photon_map_order.comp", sizeof(gpu::HashGridConstants)) {}

void HashGridGpu::record(gpu::CommandList& commands, const gpu::HashGridConstants& grid, gpu::Buffer& tracer_state,
                         uint32_t paths, UnsortedPhotons& photons, GridPhotons& to) {
    const gpu::DeviceWord count(tracer_state, PHOTONS_STORED_WORD);
    photons.sort.record(commands, photons.paths, photons.order, count, key_bits_of(paths));
    record_ordered(commands, grid, tracer_state, photons, to);
}

void HashGridGpu::record_ordered(gpu::CommandList& commands, const gpu::HashGridConstants& grid,
                                 gpu::Buffer& tracer_state, UnsortedPhotons& photons, GridPhotons& to) {
    record_cells(commands, grid, {tracer_state, photons.places, photons.paths, photons.order, photons.sort}, to.starts);
    commands.bind(order_, {gpu::read("count", tracer_state), gpu::read("order", photons.order),
                           gpu::read("places", photons.places), gpu::read("powers", photons.powers),
                           gpu::write("map_places", to.places), gpu::write("map_powers", to.powers)});
    commands.push(grid);
    commands.dispatch_threads(grid.capacity, HASH_GRID_GROUP);
}

void HashGridGpu::record_cells(gpu::CommandList& commands, const gpu::HashGridConstants& grid, const Points& points,
                               gpu::Buffer& starts) {
    commands.bind(keys_, {gpu::read("count", points.count), gpu::read("order", points.order),
                          gpu::read("places", points.places), gpu::write("keys", points.keys)});
    commands.push(grid);
    commands.dispatch_threads(grid.capacity, HASH_GRID_GROUP);
    points.sort.record(commands, points.keys, points.order, points.count, key_bits_of(grid.slots));
    record_starts(commands, grid, points.count, points.keys, starts);
}

void HashGridGpu::record_starts(gpu::CommandList& commands, const gpu::HashGridConstants& grid, gpu::Buffer& count,
                                gpu::Buffer& keys, gpu::Buffer& starts) {
    commands.bind(starts_, {gpu::read("count", count), gpu::read("keys", keys), gpu::write("starts", starts)});
    commands.push(grid);
    commands.dispatch_threads(uint64_t{grid.slots} + 1, HASH_GRID_GROUP);
}

}  // namespace photond
