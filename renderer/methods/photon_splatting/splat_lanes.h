#pragma once
// What one splat brings to kLanes visible points: the inner loop of photon splatting.

#include "renderer/methods/photon_splatting/connect_weight.h"
#include "renderer/methods/photon_splatting/splat.h"
#include "renderer/methods/photon_splatting/visible_clusters.h"
#include "renderer/photons/kernel.h"

namespace photond {

/// gain: irradiance [W m^-2] over the splat's intensity (Splat::intensity); for receivers that are not Lambert without
/// the receiver's cosine. Zero where not lit.
struct SplatGain {
    FloatLanes gain;
    FloatMask lit;
};

/// A splat in all lanes.
struct SplatBroadcast {
    /// `radius_m`: at the receivers.
    SplatBroadcast(const Splat& splat, float radius)
        : origin(broadcast(splat.origin)),
          axis(broadcast(splat.axis)),
          normal(broadcast(splat.normal)),
          radius_m(radius),
          radius_sq(sqr(radius)),
          inverse_radius_sq(1 / sqr(radius)) {}
    Vec3Lanes origin, axis, normal;
    float radius_m, radius_sq, inverse_radius_sq;
};

/// How a cluster's points receive: decided once for all of them.
enum class Receiver : uint8_t { FlatLambert, SmoothLambert, General };

/// A photon that connects (photon_splatting.h). `clamp_sq`: B [m^2], at most the squared radius.
template <Receiver kReceiver>
inline SplatGain connect_gain(const Splat& splat, const SplatBroadcast& wide, const PointBlock& points,
                              const Kernel& filter, float clamp_sq) {
    namespace stdx = std::experimental;
    const Vec3Lanes d = points.position.load() - wide.origin;
    const FloatLanes along = dot(d, wide.axis), d_sq = dot(d, d), height = dot(d, wide.normal);
    const Vec3Lanes across = d - along * wide.axis;
    const FloatLanes u_sq = select(along > 0, dot(across, across), d_sq);
    FloatMask lit = u_sq < wide.radius_sq && height > 0;
    FloatLanes cosine = 1;  // times d
    if constexpr (kReceiver != Receiver::General) {
        cosine = -dot(points.normal.load(), d);
        lit = lit && cosine > 0;
    }
    if constexpr (kReceiver == Receiver::SmoothLambert) lit = lit && dot(points.geometric_normal.load(), d) < 0;
    if (stdx::none_of(lit)) return {0, lit};

    const FloatLanes inverse_d = 1.0f / stdx::sqrt(stdx::max(d_sq, FloatLanes(1e-37f)));
    FloatLanes gain = filter(stdx::min(u_sq * wide.inverse_radius_sq, FloatLanes(1)));
    const FloatMask clipped = lit && height < wide.radius_m;
    if (stdx::any_of(clipped)) {
        const float disc_sq = wide.radius_sq * sqr(splat.disc);
        const FloatLanes factor = connect_factor(d_sq, stdx::min(height * inverse_d, FloatLanes(1)), disc_sq, clamp_sq);
        const FloatLanes of_disc = select(u_sq < disc_sq, factor * (kInvPi * wide.radius_sq / disc_sq), FloatLanes(0));
        gain = select(clipped, of_disc, gain);
    }
    gain *= wide.inverse_radius_sq;
    if constexpr (kReceiver != Receiver::General) gain *= cosine * inverse_d;
    return {select(lit, gain, FloatLanes(0)), lit};
}

/// A photon that lights along its direction. `along` and `across` are left for the depth map.
template <Receiver kReceiver>
inline SplatGain beam_gain(const Splat& splat, const SplatBroadcast& wide, const PointBlock& points,
                           const Kernel& filter) {
    namespace stdx = std::experimental;
    const Vec3Lanes d = points.position.load() - wide.origin;
    const FloatLanes along = dot(d, wide.axis);
    const Vec3Lanes across = d - along * wide.axis;
    const FloatLanes u_sq = dot(across, across);
    FloatMask lit = u_sq < wide.radius_sq && along >= splat.near_m && along <= splat.far_m;
    FloatLanes cosine = 1;
    if constexpr (kReceiver != Receiver::General) {
        cosine = -dot(points.normal.load(), wide.axis);
        lit = lit && cosine > 0;
    }
    if constexpr (kReceiver == Receiver::SmoothLambert) lit = lit && dot(points.geometric_normal.load(), wide.axis) < 0;
    if (stdx::none_of(lit)) return {0, lit};
    const FloatLanes gain = filter(stdx::min(u_sq * wide.inverse_radius_sq, FloatLanes(1))) * cosine;
    return {select(lit, gain, FloatLanes(0)), lit};
}

}  // namespace photond
