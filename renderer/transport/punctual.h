#pragma once
// How far and how wide the lights of KHR_lights_punctual shine, for those who look at a light and for those who leave
// it. https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_lights_punctual

#include <algorithm>

#include "renderer/scene/light.h"

namespace photond {

/// KHR_lights_punctual's window: 1 without a range, falling to 0 at it.
inline float range_window(float distance_m, float range_m) {
    return range_m < kInfinity ? std::clamp(1 - sqr(sqr(distance_m / range_m)), 0.0f, 1.0f) : 1.0f;
}

/// A spot's falloff: t^2, t rising from 0 to 1 between the cosines of the outer and the inner angle, and 1 within. The
/// extension keeps the two at least 0.001 apart.
class SpotCone {
public:
    explicit SpotCone(const PunctualLight& light)
        : cos_outer_(light.cos_outer), width_(std::max(0.001f, light.cos_inner - light.cos_outer)) {}

    /// Share of the intensity left at that cosine of the angle from the axis.
    float falloff(float cosine) const { return sqr(std::clamp((cosine - cos_outer_) * (1 / width_), 0.0f, 1.0f)); }
    /// Integral of the falloff over all directions [sr], closed form.
    double solid_angle() const;
    /// A unit direction about +z with density falloff / solid_angle(); u uniform in [0, 1)^2. Only when that is > 0.
    vec3 sample(const vec2& u) const;
    /// Inverse of that, for a direction of that cosine within the cone: u.x.
    float number(float cosine) const;

    /// Integrals over the cosine: where the falloff is 1, and on the ramp, which t leaves at `top` <= 1 (it does not
    /// reach 1 where the axis lies on it).
    struct Shares {
        double plateau;
        double ramp;
        double top;
    };
    Shares shares() const;
    float width() const { return width_; }
    float cos_outer() const { return cos_outer_; }

private:
    float cos_outer_;
    float width_;  // of the ramp, in the cosine
};

}  // namespace photond
