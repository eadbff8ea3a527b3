#pragma once
// Which photons lie on a disc of density estimation, and what they scatter from there to the eye: the parts that
// estimates are made of, whoever brings photon and disc together.

#include <array>
#include <bit>

#include "renderer/photons/radiance_estimate.h"
#include "renderer/transport/bsdf_evaluator.h"

namespace photond {

/// A photon's flux is L |cos_p| dw dA; the estimate divides by |cos_p| where the shading normal differs. Below this it
/// divides by this: directions are stored to 7e-5 rad, normals to 2e-3, and weights without a bound would have no
/// variance. Uniform light about a shading normal tilted by a loses at most 1e-3 sin(a) of its irradiance.
inline constexpr float kLeastCosine = DISC_LEAST_COSINE;

/// Where photons are counted.
struct Disc {
    vec3 position;
    vec3 normal;  // unit, geometric
    bool both_sides;
    uint32_t most_scatterings;
    DiscQuery query;
};

/// Which of the photons near a disc lie on it.
class DiscTest {
public:
    DiscTest(const EstimateSettings& settings, const Disc& disc, float thickness_m)
        : disc_(disc),
          thickness_m_(thickness_m),
          least_cosine_(settings.soft_disc ? 0 : kDiscCosine),
          same_normal_(Octahedral<11>::encode(disc.normal)) {}

    /// The cosine between the normals, negative on the far side; 0: refused. `height_m`: over the disc's plane or
    /// below it.
    float side(const PhotonPayload& photon, float height_m) const {
        return side(photon.normal_and_path, height_m, thickness_m_, [&] { return photon.normal(); });
    }
    /// The same of a disc of that thickness. `normal()`: of the photon, asked where it is not the disc's very own.
    template <class Normal>
    float side(uint32_t normal_and_path, float height_m, float thickness_m, const Normal& normal) const {
        if (height_m > thickness_m ||
            PhotonPayload{.normal_and_path = normal_and_path}.scatterings() > disc_.most_scatterings)
            return 0;
        // Most photons lie in the plane of the disc and have its very normal: no need to decode that.
        if ((normal_and_path & PHOTON_NORMAL_BITS) == same_normal_) return 1;
        const float side = glm::dot(normal(), disc_.normal);
        return (side < 0 && !disc_.both_sides) || std::fabs(side) < least_cosine_ ? 0 : side;
    }
    float height_m(const vec3& photon) const { return std::fabs(glm::dot(disc_.normal, photon - disc_.position)); }

private:
    const Disc& disc_;
    const float thickness_m_;
    const float least_cosine_;
    const uint32_t same_normal_;
};

/// Octahedral<16>::decode() of several.
inline Vec3Lanes decode_directions(const IntLanes& codes) {
    constexpr auto kMask = static_cast<int32_t>(Octahedral<16>::kMask);
    const auto coordinate = [](const IntLanes& code) {
        return 2.0f * std::experimental::static_simd_cast<FloatLanes>(code) * (1.0f / static_cast<float>(kMask - 1)) -
               1.0f;
    };
    const auto fold = [](const FloatLanes& x, const FloatLanes& other) {
        const FloatLanes folded = 1.0f - abs(other);
        return select(x < 0, -folded, folded);
    };
    const FloatLanes x = coordinate(codes & kMask), y = coordinate(codes >> 16 & kMask), z = 1.0f - abs(x) - abs(y);
    const Vec3Lanes n = {select(z < 0, fold(x, y), x), select(z < 0, fold(y, x), y), z};
    return 1.0f / sqrt(dot(n, n)) * n;
}

/// What photons scatter towards the eye from one point, several at a time.
class PointScattering {
public:
    /// The shading frame is borrowed.
    PointScattering(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wo)
        : frame_(point.shading), normal_(point.geometric_normal), bsdf_(bsdf, wo) {}

    const vec3& normal() const { return normal_; }
    /// `world`: towards where the light came from; `side`: positive where the photon lies on the side of the point's
    /// geometric normal; `cos_p`: between `world` and the normal of the surface it lies on.
    Vec3Lanes reflected(const Vec3Lanes& world, const FloatLanes& side, const FloatLanes& cos_p,
                        const Vec3Lanes& power) const {
        const Vec3Lanes wi = {dot(world, broadcast(frame_.tangent)), dot(world, broadcast(frame_.bitangent)),
                              dot(world, broadcast(frame_.normal))};
        // A photon of a curved surface's next facet may have come from below this one's horizon.
        const FloatMask same_side = (dot(world, broadcast(normal_)) > 0) == (side > 0);
        const FloatLanes share = select(same_side, 1.0f / max(abs(cos_p), FloatLanes(kLeastCosine)), 0);
        return share * (bsdf_.f_cos(wi) * power);
    }

private:
    const Frame& frame_;
    const vec3 normal_;  // geometric
    const BsdfEvaluator bsdf_;
};

/// Where on a disc a photon lies.
struct DiscSpot {
    float q_sq = 0;       // squared distance from the centre over the squared radius
    uint32_t sector = 0;  // DiscMoments::sectors
};

/// The sector of a direction in the disc's frame.
inline uint32_t sector_of(const Frame& frame, const vec3& offset) {
    const float x = glm::dot(offset, frame.tangent), y = glm::dot(offset, frame.bitangent);
    return (x < 0 ? 1u : 0u) | (y < 0 ? 2u : 0u) | (std::fabs(x) < std::fabs(y) ? 4u : 0u);
}

/// `light`: what the photon brings, its channels added.
inline void add_moments(DiscMoments& moments, double light, const DiscSpot& spot) {
    moments.photons += 1;
    moments.w += light;
    moments.w_sq += light * light;
    moments.w_t += light * (2 * double{spot.q_sq} - 1);
    moments.sectors[spot.sector] += light;
}

/// Sums what photons have scattered towards the eye.
class ScatteredSum {
public:
    /// `moments` to add to, unless null.
    ScatteredSum(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wo, DiscMoments* moments)
        : point_(point, bsdf, wo), normal_code_(Octahedral<11>::encode(point.geometric_normal)), moments_(moments) {
        clear();
    }

    void add(const PhotonPayload& photon, float weight, float side, const DiscSpot& spot) {
        weight_[size_] = weight, spot_[size_] = spot;
        direction_[size_] = std::bit_cast<int32_t>(photon.direction);
        for (int c = 0; c < 3; ++c) power_[static_cast<size_t>(c)][size_] = weight * photon.power_w[c];
        // Most photons have the very normal of the point, which is known better than its code.
        const bool same = (photon.normal_and_path & PHOTON_NORMAL_BITS) == normal_code_;
        const vec3 own = same ? point_.normal() : photon.normal();
        for (int c = 0; c < 3; ++c) own_normal_[static_cast<size_t>(c)][size_] = own[c];
        side_[size_] = side;
        delta_[size_] = photon.all_delta() ? 1.0f : 0.0f;
        if (++size_ == kLanes) flush();
    }

    void finish(RadianceEstimate& estimate) {
        if (size_ > 0) flush();
        estimate.radiance = {reduce(sum_.x), reduce(sum_.y), reduce(sum_.z)};
        estimate.delta_radiance = {reduce(delta_sum_.x), reduce(delta_sum_.y), reduce(delta_sum_.z)};
        estimate.scattered = scattered_;
    }

private:
    static FloatLanes load(const std::array<float, kLanes>& v) {
        return FloatLanes(v.data(), std::experimental::element_aligned);
    }
    void clear() {
        size_ = 0;
        direction_.fill(0);
        for (auto& colour : power_) colour.fill(0);
        for (auto& coordinate : own_normal_) coordinate.fill(0);
        side_.fill(1), delta_.fill(0);
    }

    void flush() {
        const Vec3Lanes world = decode_directions(IntLanes(direction_.data(), std::experimental::element_aligned));
        const FloatLanes cos_p =
            dot(world, Vec3Lanes{load(own_normal_[0]), load(own_normal_[1]), load(own_normal_[2])});
        const Vec3Lanes reflected =
            point_.reflected(world, load(side_), cos_p, {load(power_[0]), load(power_[1]), load(power_[2])});
        sum_ = sum_ + reflected;
        delta_sum_ = delta_sum_ + load(delta_) * reflected;
        scattered_ += static_cast<uint32_t>(popcount(reflected.x + reflected.y + reflected.z > 0));
        if (moments_ != nullptr) {
            const FloatLanes light = dot(reflected, broadcast(moments_->channels));
            for (size_t i = 0; i < size_; ++i)
                if (light[i] > 0) add_moments(*moments_, double{light[i]} / double{weight_[i]}, spot_[i]);
        }
        clear();
    }

    const PointScattering point_;
    const uint32_t normal_code_;
    DiscMoments* const moments_;
    uint32_t scattered_ = 0;
    size_t size_ = 0;
    std::array<float, kLanes> weight_;
    std::array<DiscSpot, kLanes> spot_;
    std::array<int32_t, kLanes> direction_;
    std::array<std::array<float, kLanes>, 3> power_;       // times weight
    std::array<std::array<float, kLanes>, 3> own_normal_;  // of the surface the photon lies on
    std::array<float, kLanes> side_, delta_;
    Vec3Lanes sum_{0, 0, 0}, delta_sum_{0, 0, 0};
};

}  // namespace photond
