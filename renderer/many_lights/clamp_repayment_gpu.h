#pragma once
// ClampRepayment (clamp_repayment.h) on a device, for the points of a GBufferGpu.

#include "renderer/gbuffer/gbuffer_gpu.h"

namespace photond {

/// What is asked for.
struct RepaymentAsks {
    bool clamped = true;  // what the clamp takes, for the layer `clamped` where it is kept ...
    bool repaid = true;   // ... and to be added to the points' sums
    bool narrow = false;  // what narrow lobes send, which is added
};

class ClampRepaymentGpu {
public:
    /// Borrows the points and the image. `adds`: what is found is added to the points' sums; the layer `clamped` gets
    /// it where it is kept.
    ClampRepaymentGpu(const gpu::DeviceScene& scene, GBufferGpu& buffer, DeviceImage& image, uint64_t seed,
                      SamplerKind sampler, const RepaymentAsks& asks);
    static uint64_t device_bytes() { return sizeof(gpu::PassSamplerData); }

    /// A pass is done in that many pieces, 0 ..., each short enough for one submit; scope `repay`. `constants`:
    /// VplLightingGpu's.
    uint32_t pieces() const { return pieces_; }
    void record(gpu::CommandList& commands, gpu::Buffer& constants, uint32_t pass, uint32_t piece);

private:
    GBufferGpu& buffer_;
    DeviceImage& image_;
    const uint64_t seed_;
    const SamplerKind sampler_kind_;
    const uint32_t points_at_once_, pieces_;
    gpu::Buffer sampler_;
    gpu::ComputePipeline pipeline_;
};

}  // namespace photond
