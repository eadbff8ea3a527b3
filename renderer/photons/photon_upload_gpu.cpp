#include "renderer/photons/photon_upload_gpu.h"

#include <algorithm>
#include <numeric>

namespace photond {

PhotonUploadGpu::PhotonUploadGpu(gpu::Device& device, uint32_t capacity)
    : capacity_(capacity),
      places_(device, "photon_upload", uint64_t{capacity} * sizeof(gpu::PhotonPlace), gpu::MemoryKind::Upload),
      powers_(device, "photon_upload", uint64_t{capacity} * sizeof(gpu::PhotonPower), gpu::MemoryKind::Upload),
      order_(device, "photon_upload", uint64_t{capacity} * sizeof(uint32_t), gpu::MemoryKind::Upload),
      state_(device, "photon_tracer", PhotonTracerGpu::kStateBytes) {
    const std::span<uint32_t> order = order_.as<uint32_t>();
    std::iota(order.begin(), order.end(), 0u);  // they are in the order of their paths
}

uint64_t PhotonUploadGpu::bytes_for(uint64_t capacity) {
    return capacity * (sizeof(gpu::PhotonPlace) + sizeof(gpu::PhotonPower) + sizeof(uint32_t)) +
           PhotonTracerGpu::kStateBytes;
}

void PhotonUploadGpu::record(gpu::CommandList& commands, std::span<const Photon> photons, UnsortedPhotons& to) {
    const size_t count = std::min<size_t>(photons.size(), capacity_);
    const std::span<gpu::PhotonPlace> places = places_.as<gpu::PhotonPlace>();
    const std::span<gpu::PhotonPower> powers = powers_.as<gpu::PhotonPower>();
    for (size_t i = 0; i < count; ++i) {
        const auto& [position, payload] = photons[i];
        places[i] = {position, payload.normal_and_path};
        powers[i] = {payload.power_w, payload.direction};
    }
    std::array<uint32_t, PHOTON_STATE_WORDS> state{};
    state[PHOTONS_STORED_WORD] = static_cast<uint32_t>(photons.size());
    commands.update(state_, state);
    if (count == 0) return;
    commands.copy(places_, 0, to.places, 0, count * sizeof(gpu::PhotonPlace));
    commands.copy(powers_, 0, to.powers, 0, count * sizeof(gpu::PhotonPower));
    commands.copy(order_, 0, to.order, 0, count * sizeof(uint32_t));
}

}  // namespace photond
