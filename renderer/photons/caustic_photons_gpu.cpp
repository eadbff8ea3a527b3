#include "renderer/photons/caustic_photons_gpu.h"

#include "renderer/photons/projection_map.h"

namespace photond {

namespace {

/// Photons that the map is laid out for.
uint64_t expected_photons(double yield, uint32_t paths) { return static_cast<uint64_t>(yield * paths) + 1; }

void append(std::vector<gpu::Binding>& bindings, gpu::Buffer& starts, gpu::Buffer& places, gpu::Buffer& powers,
            gpu::Buffer& estimate) {
    bindings.insert(bindings.end(), {gpu::read("grid_starts", starts), gpu::read("grid_places", places),
                                     gpu::read("map_powers", powers), gpu::read("caustic_estimate", estimate)});
}

}  // namespace

CausticPhotonsGpu::CausticPhotonsGpu(const gpu::DeviceScene& scene, std::unique_ptr<CausticPhotons> host, uint64_t seed)
    : host_(std::move(host)),
      seed_(seed),
      maps_(scene),
      estimate_(scene.device(), "photon_maps", sizeof(gpu::EstimateConstants)) {
    const PhotonTracing& tracing = host_->tracing();
    maps_.add(PHOTON_MAP_CAUSTIC, tracing, expected_photons(host_->photons_a_path(), tracing.photons));
    maps_.make_room();
}

uint64_t CausticPhotonsGpu::device_bytes(const CausticSettings& settings, double yield, uint64_t lights) {
    const uint64_t expected = expected_photons(yield, settings.photons);
    const uint64_t room = PhotonMapsGpu::room_for(static_cast<double>(expected));
    return PhotonMapsGpu::map_bytes(expected, room) + PhotonMapsGpu::shared_bytes(room) +
           PhotonTracerGpu::device_bytes(0, ProjectionMap::estimate_bytes(lights)) + sizeof(gpu::EstimateConstants);
}

void CausticPhotonsGpu::record(gpu::CommandList& commands, uint32_t pass, uint32_t piece) {
    if (piece == 0) {
        const float radius_m = host_->radius_m(pass);
        gpu::EstimateConstants estimate{.kernel = CausticPhotons::estimate().kernel.device_record(),
                                        .disc_thickness_m = -1};
        estimate.maps[PHOTON_MAP_CAUSTIC] = {maps_.cut_cells(PHOTON_MAP_CAUSTIC, radius_m), radius_m, 2};
        commands.update(estimate_, estimate);
    }
    maps_.record(commands, PHOTON_MAP_CAUSTIC, seed_, pass, piece);
}

bool CausticPhotonsGpu::grow_if_short() {
    if (!maps_.is_short()) return false;
    maps_.make_room();
    return true;
}

void CausticPhotonsGpu::append_to(std::vector<gpu::Binding>& bindings) {
    append(bindings, maps_.photons().starts, maps_.photons().places, maps_.photons().powers, estimate_);
}

NoCausticPhotons::NoCausticPhotons(gpu::Device& device) : nothing_(device, "photon_maps", device_bytes()) {}

void NoCausticPhotons::append_to(std::vector<gpu::Binding>& bindings) {
    append(bindings, nothing_, nothing_, nothing_, nothing_);
}

}  // namespace photond
