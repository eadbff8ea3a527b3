#pragma once
// ClampRepayment (clamp_repayment.h) on a device, for the points of a GBufferGpu.

#include "renderer/gbuffer/gbuffer_gpu.h"
#include "renderer/photons/caustic_photons_gpu.h"

namespace photond {

/// What is asked for.
struct RepaymentAsks {
    bool clamped = true;  // what the clamp takes, for the layer `clamped` where it is kept ...
    bool repaid = true;   // ... and to be added to the points' sums
    bool narrow = false;  // what narrow lobes send, which is added
};

class ClampRepaymentGpu {
public:
    /// Borrows the points, the image and the caustics. The layer `clamped` gets what the clamp takes where it is kept.
    /// `caustics`: null, or photons in the place of lights behind specular scatterings; the points' own are added too.
    ClampRepaymentGpu(const gpu::DeviceScene& scene, GBufferGpu& buffer, DeviceImage& image, uint64_t seed,
                      SamplerKind sampler, const RepaymentAsks& asks, CausticPhotonsGpu* caustics = nullptr);
    static uint64_t device_bytes() { return sizeof(gpu::PassSamplerData) + NoCausticPhotons::device_bytes(); }

    /// A pass is done in that many pieces, 0 ..., each short enough for one submit; scope `repay`. `constants`:
    /// VplLightingGpu's.
    uint32_t pieces() const { return pieces_; }
    void record(gpu::CommandList& commands, gpu::Buffer& constants, uint32_t pass, uint32_t piece);

private:
    GBufferGpu& buffer_;
    DeviceImage& image_;
    CausticPhotonsGpu* const caustics_;
    NoCausticPhotons no_caustics_;
    const uint64_t seed_;
    const SamplerKind sampler_kind_;
    const uint32_t points_at_once_, pieces_;
    gpu::Buffer sampler_;
    gpu::ComputePipeline pipeline_;
};

}  // namespace photond
