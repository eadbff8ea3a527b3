#pragma once
#include "renderer/methods/photon_splatting/photon_splatting.h"

namespace photond {

/// PhotonSplatting on a GPU: the same visible points, the same photons (in another order), and what photons bring to
/// points by the same formulae, so that images differ from the CPU's by rounding and, where numbers go by a photon's
/// place in the order or a splat's size by where its cluster lies, by noise. Sums are taken in one order: the same
/// image from run to run on one device.
///
/// Visible points lie tile by tile (splat_eye.comp); each tile's points at one vertex are a cluster, lit by a group of
/// threads that goes through all splats (splat_light.comp). Splats come in batches, so that their depth maps are
/// bounded. V of connections is found by shadow rays.
class PhotonSplattingGpu final : public Method {
public:
    using Params = PhotonSplattingParams;

    explicit PhotonSplattingGpu(const PhotonSplattingParams& params);
    ~PhotonSplattingGpu() override;
    /// Throws ErrorCode::Unsupported, with a pointer to the parameter, for what only the CPU has.
    static void check_gpu(const PhotonSplattingParams& params);
    /// What begin() will record of the host's memory ...
    static uint64_t estimate_bytes(const PhotonSplattingParams& params, const Workload& workload);
    /// ... and take of the device's.
    static uint64_t estimate_device_bytes(const PhotonSplattingParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    void expect_pass(uint32_t pass) override;
    void settle() override;
    void resolve(Film& film) override;

private:
    struct State;  // photon_splatting_gpu.cpp

    bool look_and_trace(uint32_t pass, Stats& stats, const CancelToken& cancel);

    const PhotonSplattingParams params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
