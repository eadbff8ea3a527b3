#include "renderer/photons/caustic_photons_gpu.h"

#include <algorithm>

#include "protocol/error.h"
#include "renderer/photons/projection_map.h"

namespace photond {

namespace {

/// A quarter more than expected.
uint64_t room_for(double stored) { return static_cast<uint64_t>(1.25 * stored) + 1024; }

void append(std::vector<gpu::Binding>& bindings, gpu::Buffer& starts, gpu::Buffer& places, gpu::Buffer& powers,
            gpu::Buffer& estimate) {
    bindings.insert(bindings.end(), {gpu::read("grid_starts", starts), gpu::read("grid_places", places),
                                     gpu::read("map_powers", powers), gpu::read("caustic_estimate", estimate)});
}

}  // namespace

CausticPhotonsGpu::CausticPhotonsGpu(const gpu::DeviceScene& scene, std::unique_ptr<CausticPhotons> host, uint64_t seed)
    : device_(scene.device()),
      bounds_(scene.scene().bounds),
      host_(std::move(host)),
      seed_(seed),
      expected_(static_cast<uint64_t>(host_->photons_a_path() * host_->tracing().photons) + 1),
      tracer_(scene, host_->tracing()),
      hash_grid_(device_),
      estimate_(device_, "photon_maps", sizeof(gpu::EstimateConstants)),
      host_state_(device_, "readback", PhotonTracerGpu::kStateBytes, gpu::MemoryKind::Readback) {
    make_room(room_for(static_cast<double>(expected_)));
}

uint64_t CausticPhotonsGpu::device_bytes(const CausticSettings& settings, double yield, uint64_t lights) {
    const double stored = yield * settings.photons;
    const uint64_t capacity = room_for(stored);
    return GridPhotons::bytes_for(grid_starts_for(static_cast<uint64_t>(stored) + 1), capacity) +
           UnsortedPhotons::bytes_for(capacity) +
           PhotonTracerGpu::device_bytes(0, ProjectionMap::estimate_bytes(lights)) + sizeof(gpu::EstimateConstants);
}

void CausticPhotonsGpu::make_room(uint64_t capacity) {
    if (capacity > uint64_t{1} << 31)
        throw Error(ErrorCode::OutOfMemory,
                    "caustic photons are " + std::to_string(capacity) + ", and at most 2147483648 can be sorted");
    photons_.reset(), map_.reset();  // not both at once
    capacity_ = static_cast<uint32_t>(capacity);
    photons_.emplace(device_, capacity_);
    map_.emplace(device_, grid_starts_for(expected_), capacity);
}

uint32_t CausticPhotonsGpu::pieces() const {
    const uint32_t most = device_.paths_per_submit();
    return (tracer_.tracing().photons + most - 1) / most;
}

void CausticPhotonsGpu::record(gpu::CommandList& commands, uint32_t pass, uint32_t piece) {
    const uint32_t paths = tracer_.tracing().photons, most = device_.paths_per_submit();
    const uint32_t first = piece * most, end = paths - first > most ? first + most : paths;
    const float radius_m = host_->radius_m(pass);
    gpu::HashGridConstants grid = lay_out_grid(bounds_, radius_m, expected_);
    grid.capacity = capacity_;
    {
        const gpu::Scope scope(commands, "photon_tracing");
        if (piece == 0) {
            gpu::EstimateConstants estimate{.kernel = CausticPhotons::estimate().kernel.device_record(),
                                            .disc_thickness_m = -1};
            estimate.maps[PHOTON_MAP_CAUSTIC] = {grid, radius_m, 2};
            commands.update(estimate_, estimate);
            tracer_.record_start(commands);
        }
        tracer_.record_paths(commands, seed_, pass, first, end, *photons_, capacity_);
    }
    if (end < paths) return;
    const gpu::Scope scope(commands, "photon_map_build");
    hash_grid_.record(commands, grid, tracer_.state(), paths, *photons_, *map_);
    commands.copy(tracer_.state(), 0, host_state_, 0, PhotonTracerGpu::kStateBytes);
    commands.host_reads(host_state_);
}

bool CausticPhotonsGpu::grow_if_short() {
    const uint64_t stored = state()[PHOTONS_STORED_WORD];
    if (stored <= capacity_) return false;
    make_room(room_for(static_cast<double>(stored)));
    return true;
}

void CausticPhotonsGpu::append_to(std::vector<gpu::Binding>& bindings) {
    append(bindings, map_->starts, map_->places, map_->powers, estimate_);
}

NoCausticPhotons::NoCausticPhotons(gpu::Device& device) : nothing_(device, "photon_maps", device_bytes()) {}

void NoCausticPhotons::append_to(std::vector<gpu::Binding>& bindings) {
    append(bindings, nothing_, nothing_, nothing_, nothing_);
}

}  // namespace photond
