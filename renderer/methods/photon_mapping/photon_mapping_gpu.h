#pragma once
#include "renderer/frame/device_method.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"

namespace photond {

/// PhotonMapping on a GPU: the same photons and eye paths with the same numbers, so that the image differs from the
/// CPU's by rounding alone (a path that rounding sends elsewhere is a sample of its own right). Photons are sorted into
/// one order before they are summed, so the image is the same from run to run on one device.
///
/// Both searches run on a hash grid; the k nearest are found exactly (radiance_estimate.glsl). Room for photons is made
/// by what scenes are expected to store; a pass that stores more is traced again with room for all. Stage `direct` is
/// what paths from the eye take, and `gather` what gather rays do; without these both are one, `gather`.
class PhotonMappingGpu final : public DeviceMethod {
public:
    using Params = PhotonMappingParams;

    explicit PhotonMappingGpu(const PhotonMappingParams& params);
    ~PhotonMappingGpu() override;
    /// Throws ErrorCode::Unsupported for what only the CPU has: `shadow_photons`, `gather_sampling` "photons" and
    /// `keep_photon_map`.
    static void check_gpu(const PhotonMappingParams& params);
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const PhotonMappingParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take, to a few percent where the photons are as many as expected.
    static uint64_t estimate_device_bytes(const PhotonMappingParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

private:
    DeviceFrame& frame() override;

    struct State;  // photon_mapping_gpu.cpp

    const PhotonMappingParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
