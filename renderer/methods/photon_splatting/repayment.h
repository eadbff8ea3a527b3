#pragma once
// What the clamp of connections takes, given back (derivations.md, "The VPL clamp and its exact repayment").
//
// A connection over a distance d counts as if it were at least sqrt(B). What is missing at x is
//   int L_o(y) f(x) cos_x (1 - d^2/B)^+ dw,
// L_o the light that connects from y: scattered there by its rough part, of as many bounces as photons may have. One
// cosine-distributed ray of length sqrt(B) a visible point finds y; light samples there, and for more bounces a path on
// from there, find L_o. Where nothing is near, no ray is traced.

#include "renderer/methods/eye_scene.h"
#include "renderer/methods/photon_splatting/splat_settings.h"
#include "renderer/methods/photon_splatting/visible_clusters.h"

namespace photond {

/// What all threads share.
struct RepaymentScene {
    const EyeScene& eye;
    float connect_threshold;        // of the rough part that connects
    const ShaftVisibility* shafts;  // null: rays are traced everywhere
};

/// Scratch of one thread.
class Repayment {
public:
    /// Adds to the sums of the cluster's points. Rays go to `counts` as bounce and shadow rays. `sampler`: numbers of
    /// the pass, of RandomDomain::Splats.
    void repay(const RepaymentScene& shared, const PassSampler& sampler, const VisibleCluster& cluster,
               PointTile& points, Counts& counts);

private:
    struct Path {
        Rgb throughput;  // radiance at the end becomes what is added to the point's sum
        uint32_t point;  // of the cluster
        uint32_t key;
        float pdf_sa = 0;  // of the direction, against light samples
        bool delta = false;
        vec3 position{0}, lit_normal{0};
        MediumStack media;
    };
    struct Light {
        Rgb light;
        uint32_t point;
    };

    void start(const PassSampler& sampler, const VisibleCluster& cluster, const PointTile& points);
    void scatter(const RepaymentScene& shared, const PassSampler& sampler, uint32_t vertex, int64_t left, size_t i);
    void sample_light(const RepaymentScene& shared, const PassSampler& sampler, uint32_t vertex, const Path& path,
                      const ShadingPoint& at, const Bsdf& bsdf, const vec3& wo, bool competes);
    void add(uint32_t point, const Rgb& light);

    PointBlock* blocks_ = nullptr;
    float clamp_sq_m2_ = 0;  // B of the cluster
    std::vector<Ray> rays_, next_rays_, shadow_rays_;
    std::vector<Hit> hits_;
    std::vector<Path> paths_, next_paths_;
    std::vector<Light> lights_;
    std::vector<uint8_t> occluded_;
};

}  // namespace photond
