#pragma once
// Photons that the host has traced, brought to a device: as PhotonTracerGpu would have left them there.

#include <span>

#include "renderer/photons/photon_tracer_gpu.h"

namespace photond {

class PhotonUploadGpu {
public:
    /// `capacity`: most photons of a pass.
    PhotonUploadGpu(gpu::Device& device, uint32_t capacity);
    /// Of the host's memory that the device reads, and of its own.
    static uint64_t bytes_for(uint64_t capacity);

    /// Brings a pass's photons, as many as there is room for; more are counted alone. What was brought before must have
    /// arrived.
    void record(gpu::CommandList& commands, std::span<const Photon> photons, UnsortedPhotons& to);

    /// Words of photon_tracing_shared.h: how many photons the pass has, and nothing else.
    gpu::Buffer& state() { return state_; }

private:
    const uint32_t capacity_;
    gpu::Buffer places_, powers_, order_;  // the host writes them
    gpu::Buffer state_;
};

}  // namespace photond
