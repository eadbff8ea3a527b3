#pragma once
// One radius for all points: r_i^2 = r_1^2 Gamma(i + alpha) / (Gamma(1 + alpha) Gamma(i + 1)). [Knaus and Zwicker 2011]

#include "renderer/progressive/disc_radii.h"

namespace photond {

class GlobalRadii final : public DiscRadii {
public:
    GlobalRadii(const DiscRadiiInputs& inputs, Stats& stats);

    std::optional<float> grid_radius_m(PhotonMapKind kind) const override { return pass_m_[index_of(kind)]; }
    void begin_pass(uint32_t pass) override;
    float radius_m(PhotonMapKind kind, const DiscPlace& place, Neighbours& scratch) override;
    uint64_t bytes() const override { return sizeof *this; }

private:
    const double alpha_;
    PerMap<float> first_m_{}, pass_m_{};
};

}  // namespace photond
