#pragma once
#include <memory>

#include "renderer/frame/device_method.h"
#include "renderer/methods/image_space_photon_mapping/params.h"

namespace photond {

/// Image-space photon mapping, on GPUs: photons of every bounce after the first light the pixels about them, instead of
/// pixels looking for photons. A pixel's light is the sum over photons of f (n_p . n) Phi kappa(|s - s_p|): f the BSDF,
/// (n_p . n) the agreement of both surfaces' normals, Phi the photon's power, kappa a radial kernel of integral 1 over
/// the disc of the footprint's radius [Yao 2011, equation 1]. What the eye sees by mirrors and glass is lit where its
/// path first meets another surface.
///
/// Biased by the footprints, which blur. Whole ones lose light where a surface ends within them, and light what lies
/// behind a wall that stands there; with `boundary` clip a pixel near an edge divides by the part of its disc that
/// light can reach, and takes no photon that is not seen from above it (disc_coverage.h). With `shrink` footprints
/// shrink from pass to pass, and the mean of the passes converges.
///
/// Direct light is shadowed by rays to all of a light, or, with another `soft_shadow`, by one to its middle, and that
/// blurred in the image (soft_shadows.glsl): for real time, and biased for ever.
///
/// With `subsampling` some pixels take their light from those about them (upsampling.glsl), whatever the pass: that
/// bias stays.
///
/// [Yao 2011] Combining Soft Shadow and Image Space Photon Mapping for Global Illumination. Thesis.
/// [McGuire and Luebke 2009] Hardware-Accelerated Global Illumination by Image Space Photon Mapping. HPG.
class ImageSpacePhotonMappingGpu final : public DeviceMethod {
public:
    static constexpr const char* kName = "image_space_photon_mapping";
    using Params = ImageSpacePhotonMappingParams;

    explicit ImageSpacePhotonMappingGpu(const ImageSpacePhotonMappingParams& params);
    ~ImageSpacePhotonMappingGpu() override;
    static bool traces_on_host(const ImageSpacePhotonMappingParams& params) { return params.traces_on_host(); }
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const ImageSpacePhotonMappingParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take, to a factor of two.
    static uint64_t estimate_device_bytes(const ImageSpacePhotonMappingParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    void expect_pass(uint32_t pass) override;
    void settle() override;

private:
    DeviceFrame& frame() override;

    struct State;  // image_space_photon_mapping_gpu.cpp

    const ImageSpacePhotonMappingParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
