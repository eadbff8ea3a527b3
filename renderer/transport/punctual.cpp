#include "renderer/transport/punctual.h"

#include <numbers>

namespace photond {

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

}  // namespace

SpotCone::Shares SpotCone::shares() const {
    const double to_axis = 1 - double{cos_outer_};  // from the rim, in the cosine
    const double top = std::clamp(to_axis / width_, 0.0, 1.0);
    return {std::max(0.0, to_axis - width_), width_ * top * top * top / 3, top};
}

double SpotCone::solid_angle() const {
    const Shares s = shares();
    return kTwoPi * (s.plateau + s.ramp);
}

vec3 SpotCone::sample(const vec2& u) const {
    // From the axis outwards, in 1 - cos: the sine of a narrow cone would lose its digits in the cosine.
    const Shares s = shares();
    const double x = u.x * (s.plateau + s.ramp);
    double below_one = x;
    if (x >= s.plateau) {
        const double rest = std::max(0.0, 1 - (x - s.plateau) / s.ramp);  // of the ramp, outside of this direction
        below_one = 1 - double{cos_outer_} - width_ * s.top * std::cbrt(rest);
    }
    below_one = std::clamp(below_one, 0.0, 2.0);
    const float sine = static_cast<float>(std::sqrt(below_one * (2 - below_one)));
    const float azimuth = static_cast<float>(kTwoPi) * u.y;
    return {sine * std::cos(azimuth), sine * std::sin(azimuth), static_cast<float>(1 - below_one)};
}

float SpotCone::number(float cosine) const {
    const Shares s = shares();
    const double below_one = 1 - double{cosine}, whole = s.plateau + s.ramp;
    if (below_one <= s.plateau) return static_cast<float>(below_one / whole);
    const double rest = std::clamp((1 - double{cos_outer_} - below_one) / (width_ * s.top), 0.0, 1.0);
    return static_cast<float>((s.plateau + s.ramp * (1 - rest * rest * rest)) / whole);
}

}  // namespace photond
