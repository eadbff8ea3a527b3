#pragma once
// Adds a batch's splats to the visible points of a cluster.

#include "renderer/methods/photon_splatting/splat_batch.h"
#include "renderer/methods/photon_splatting/splat_lanes.h"
#include "renderer/transport/bsdf_evaluator.h"

namespace photond {

/// Scratch of one thread.
class SplatAccumulator {
public:
    static constexpr size_t kShadowRays = 512;  // of a batch

    SplatAccumulator();
    static uint64_t bytes_per_thread();

    /// Adds to the sums of the cluster's points, in the order of the splats; shadow rays to `counts`.
    void light(const SplatPass& pass, const SplatBatch& batch, uint32_t cluster, PointTile& points, Counts& counts);

private:
    /// A connection that waits for its shadow ray.
    struct Pending {
        const Splat* splat;
        const RoughOrigin* rough;  // null: a Lambert reflector
        uint32_t point;            // of the cluster
        float gain;
    };
    /// Light that waits until a point's evaluator has its lanes full.
    struct Arriving {
        Vec3Array wi;          // local
        Vec3Array irradiance;  // perpendicular to wi [W m^-2]
        uint32_t count = 0;
    };

    template <Receiver kReceiver>
    void light_cluster(const SplatPass& pass, const SplatBatch& batch, uint32_t cluster, Counts& counts);
    template <Receiver kReceiver>
    void take(const SplatPass& pass, const Splat& splat, const RoughOrigin* rough, uint32_t block,
              const SplatGain& gain, bool clear, Counts& counts);
    template <Receiver kReceiver>
    void add_one(const SplatPass& pass, const Splat& splat, const RoughOrigin* rough, uint32_t point, float gain);
    template <Receiver kReceiver>
    void trace_shadow_rays(const SplatPass& pass, Counts& counts);
    void shade_arriving(uint32_t point);

    PointTile* tile_ = nullptr;
    PointBlock* blocks_ = nullptr;  // of the cluster
    std::vector<Ray> rays_;
    std::vector<Pending> pending_;
    std::vector<uint8_t> occluded_;
    std::vector<Arriving> arriving_;                        // by point of the cluster
    std::vector<std::optional<BsdfEvaluator>> evaluators_;  // by point
};

}  // namespace photond
