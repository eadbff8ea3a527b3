#pragma once
// One radius for each place, found by a pilot and shrinking by the pass's index: passes stand alone.
//
// For radii r_i = r_0 i^(-1/6), V = r^2 times the variance of one pass, and E the irradiance, the mean of N passes has
// the least squared error for r_0^6 = 32 V / (3 lap(E)^2), whatever N is [Kaplanyan and Dachsbacher 2013]. Both V and
// lap(E) are asked of the photons on one disc of radius r: with the sums of DiscMoments over a pilot of P passes,
// z = sqrt(3) w_t / sqrt(w_sq) is the curvature over its own standard error (believing-errors, section 3), and
//
//   r_0 = r (P / (18 z^2))^(1/6).
//
// The disc is the smallest of a row, each with twice the photons of the one before, in which z is more than chance; on
// larger ones light is no longer a quadratic function of place. Where none is, the largest one's z^2, less the 1 that
// chance puts there and at least 1, is an upper bound. Other kernels than the constant one are wider by their own bias
// and variance. The places are what the eye sees in a small image of the same view.

#include "renderer/progressive/disc_radii.h"
#include "renderer/progressive/radius_map.h"

namespace photond {

class TrainedRadii final : public DiscRadii {
public:
    /// Traces the pilots, and what the eye sees.
    TrainedRadii(const DiscRadiiInputs& inputs, Stats& stats);

    std::optional<float> grid_radius_m(PhotonMapKind kind) const override {
        return share_ * first_m_[index_of(kind)].most_m();
    }
    void begin_pass(uint32_t pass) override;
    float radius_m(PhotonMapKind kind, const DiscPlace& place, Neighbours& scratch) override;
    uint64_t bytes() const override;
    /// For a device: the radii of a pass whose share is 1, and the share of the pass begun.
    const RadiusMap& first_m(PhotonMapKind kind) const { return first_m_[index_of(kind)]; }
    float share() const { return share_; }
    static DiscRadiiBytes bytes_for(const ProgressiveParams& params, const Workload& workload);

private:
    const double alpha_;
    const RadiusLimits limits_;
    PerMap<RadiusMap> first_m_;
    float share_ = 1;  // of the pass begun
};

}  // namespace photond
