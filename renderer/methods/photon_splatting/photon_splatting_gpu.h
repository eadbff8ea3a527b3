#pragma once
#include "renderer/frame/device_method.h"
#include "renderer/methods/photon_splatting/photon_splatting.h"

namespace photond {

/// PhotonSplatting on a GPU: the same visible points, the same photons (in another order), and what photons bring to
/// points by the same formulae, so that images differ from the CPU's by rounding and, where numbers go by a photon's
/// place in the order or a splat's size by where its cluster lies, by noise. Sums are taken in one order: the same
/// image from run to run on one device.
///
/// Visible points lie tile by tile (splat_eye.comp); each tile's points at one vertex are a cluster, lit by a group of
/// threads that goes through all splats (splat_light.comp). Splats come in batches, so that their depth maps are
/// bounded. V of connections is exact: shafts tell the few triangles that may stand between a photon and a cluster
/// (transport/shaft_visibility.glsl), and where they are many or bent shadow rays are traced. Stratified photons are
/// those of the CPU's chances, not its choices, as their order is another (stratification_gpu.h). Depth maps of beams
/// are traced, or drawn where triangles are few (splat_depth_atlas.h). The blur is the host's, on what it reads back.
class PhotonSplattingGpu final : public DeviceMethod {
public:
    using Params = PhotonSplattingParams;

    /// How beams light the visible points. Estimates are of the first.
    enum class Beams : uint8_t {
        Clusters,  // splat by splat, all that may reach a cluster
        Volumes,   // drawn over the image, where that can be (splat_volumes.h); else the other
    };

    explicit PhotonSplattingGpu(const PhotonSplattingParams& params, Beams beams = Beams::Clusters);
    ~PhotonSplattingGpu() override;
    /// Bytes of the host's memory that begin() will record.
    static uint64_t estimate_bytes(const PhotonSplattingParams& params, const Workload& workload);
    /// Bytes of the device's memory that begin() will take.
    static uint64_t estimate_device_bytes(const PhotonSplattingParams& params, const Workload& workload);

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;

private:
    DeviceFrame& frame() override;

    struct State;  // photon_splatting_gpu.cpp

    bool look_and_trace(uint32_t pass, Stats& stats, const CancelToken& cancel);

    const PhotonSplattingParams params_;
    const Beams beams_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
