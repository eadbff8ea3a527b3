#include "renderer/photons/radiance_estimate.h"

#include <array>
#include <bit>

#include "renderer/photons/disc_coverage.h"
#include "renderer/transport/bsdf_evaluator.h"

namespace photond {

namespace {

/// A photon's flux is L |cos_g| dw dA; the estimate divides by |cos_g| where the shading normal differs. Below this it
/// divides by this: directions are stored to 7e-5 rad, and weights without a bound would have no variance. Uniform
/// light about a shading normal tilted by a loses at most 1e-3 sin(a) of its irradiance.
constexpr float kLeastCosine = 1e-3f;

/// Where photons are counted.
struct Disc {
    vec3 position;
    vec3 normal;  // unit, geometric
    bool both_sides;
    uint32_t most_scatterings;
    uint32_t turn;
};

/// Calls take(payload, weight, side) for each of the photons found that lies on the disc; `weight` is K r^2, `side` the
/// cosine between the normals, negative on the far side. Returns how many there were.
template <class Structure, class Take>
uint32_t take_photons(const Structure& structure, const PhotonMap& map, const EstimateSettings& settings,
                      const Disc& disc, float thickness_m, const Neighbours& found, const Take& take) {
    const float inverse_radius_sq = 1 / sqr(found.radius_m);
    // Most photons lie in the plane of the disc and have its very normal: no need to decode that.
    const uint32_t same_normal = Octahedral<11>::encode(disc.normal);
    constexpr uint32_t kNormalBits = (1u << 22) - 1;
    uint32_t taken = 0;
    // Payloads lie where no search has been yet: waiting for them one by one would take longer than all the rest.
    for (const Neighbours::Found& f : found.found) __builtin_prefetch(&map.payload(f.index).normal_and_path);
    for (const Neighbours::Found& f : found.found) {
        const PhotonPayload& payload = map.payload(f.index);
        const float height_m = std::fabs(glm::dot(disc.normal, structure.position(f.index) - disc.position));
        if (height_m > thickness_m || payload.scatterings() > disc.most_scatterings) continue;
        float side = 1;
        if ((payload.normal_and_path & kNormalBits) != same_normal) {
            side = glm::dot(payload.normal(), disc.normal);
            if (side < 0 && !disc.both_sides) continue;
            if (!settings.soft_disc && std::fabs(side) < kDiscCosine) continue;
        }
        float weight = settings.kernel(f.distance_sq_m2 * inverse_radius_sq);
        if (settings.soft_disc) weight *= std::fabs(side) * (thickness_m > 0 ? 1 - height_m / thickness_m : 1.0f);
        take(payload, weight, side);
        ++taken;
    }
    return taken;
}

/// What sums of weight x power are to be multiplied by, and what was found.
struct DiscSum {
    float scale_per_m2 = 0;
    uint32_t photons = 0;
    float radius_m = 0;
};

template <class Take>
DiscSum sum_over_disc(const PhotonMap& map, const EstimateSettings& settings, const Disc& disc, Neighbours& scratch,
                      const Take& take) {
    map.find(disc.position, scratch);
    DiscSum sum;
    sum.radius_m = scratch.radius_m;
    // As many photons as are looked for in one place leave no disc to spread them over: no density, and of that place
    // without area no light. Nor is there one where a disc is without end.
    const float area = sqr(scratch.radius_m);
    if (scratch.found.empty() || !(area >= std::numeric_limits<float>::min() && area < kInfinity)) return sum;
    const float thickness_m = settings.disc_thickness_m.value_or(0.25f * scratch.radius_m);
    DiscCoverage::Found coverage;
    if (settings.coverage != nullptr)
        coverage = settings.coverage->look_up(settings.kernel, disc.position, disc.normal, scratch.radius_m,
                                              thickness_m, disc.turn);
    if (coverage.hides) {
        std::erase_if(scratch.found, [&](const Neighbours::Found& f) {
            return !settings.coverage->sees(coverage, disc.normal, scratch.radius_m, map.position(f.index));
        });
    }
    if (const KdTree* tree = map.kd_tree()) {
        sum.photons = take_photons(*tree, map, settings, disc, thickness_m, scratch, take);
    } else {
        sum.photons = take_photons(*map.hash_grid(), map, settings, disc, thickness_m, scratch, take);
    }
    if (sum.photons == 0) return sum;
    sum.scale_per_m2 = coverage.inverse_mass / area;
    return sum;
}

/// Octahedral<16>::decode() of several.
Vec3Lanes decode_directions(const IntLanes& codes) {
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

/// Sums what photons have scattered towards the eye, several at a time.
class ScatteredSum {
public:
    ScatteredSum(const ShadingPoint& point, const Bsdf& bsdf, const vec3& wo)
        : frame_(point.shading), normal_local_(frame_.to_local(point.geometric_normal)), bsdf_(bsdf, wo) {
        clear();
    }

    void add(const PhotonPayload& photon, float weight, float side) {
        direction_[size_] = std::bit_cast<int32_t>(photon.direction);
        for (int c = 0; c < 3; ++c) power_[static_cast<size_t>(c)][size_] = weight * photon.power_w[c];
        side_[size_] = side;
        delta_[size_] = photon.all_delta() ? 1.0f : 0.0f;
        if (++size_ == kLanes) flush();
    }

    void finish(RadianceEstimate& estimate) {
        if (size_ > 0) flush();
        estimate.radiance = {reduce(sum_.x), reduce(sum_.y), reduce(sum_.z)};
        estimate.delta_radiance = {reduce(delta_sum_.x), reduce(delta_sum_.y), reduce(delta_sum_.z)};
    }

private:
    static FloatLanes load(const std::array<float, kLanes>& v) {
        return FloatLanes(v.data(), std::experimental::element_aligned);
    }
    void clear() {
        size_ = 0;
        direction_.fill(0);
        for (auto& colour : power_) colour.fill(0);
        side_.fill(1), delta_.fill(0);
    }

    void flush() {
        const Vec3Lanes world = decode_directions(IntLanes(direction_.data(), std::experimental::element_aligned));
        const Vec3Lanes wi = {dot(world, broadcast(frame_.tangent)), dot(world, broadcast(frame_.bitangent)),
                              dot(world, broadcast(frame_.normal))};
        const FloatLanes cos_g = dot(wi, broadcast(normal_local_));
        // A photon of a curved surface's next facet may have come from below this one's horizon.
        const FloatMask same_side = (cos_g > 0) == (load(side_) > 0);
        const FloatLanes share = select(same_side, 1.0f / max(abs(cos_g), FloatLanes(kLeastCosine)), 0);
        const Vec3Lanes reflected =
            share * (bsdf_.f_cos(wi) * Vec3Lanes{load(power_[0]), load(power_[1]), load(power_[2])});
        sum_ = sum_ + reflected;
        delta_sum_ = delta_sum_ + load(delta_) * reflected;
        clear();
    }

    const Frame& frame_;
    const vec3 normal_local_;
    const BsdfEvaluator bsdf_;
    size_t size_ = 0;
    std::array<int32_t, kLanes> direction_;
    std::array<std::array<float, kLanes>, 3> power_;  // times weight
    std::array<float, kLanes> side_, delta_;
    Vec3Lanes sum_{0, 0, 0}, delta_sum_{0, 0, 0};
};

}  // namespace

RadianceEstimate estimate_radiance(const PhotonMap& map, const EstimateSettings& settings, const ShadingPoint& point,
                                   const Bsdf& bsdf, const vec3& wo, uint32_t most_scatterings, Neighbours& scratch,
                                   uint32_t turn) {
    RadianceEstimate estimate;
    if (!bsdf.has_non_delta()) return estimate;
    const vec3 normal = point.geometric_normal;
    const Disc disc{point.position, normal, bsdf.has_non_delta_transmission(), most_scatterings, turn};
    Rgb factor(1);
    DiscSum sum;
    if (bsdf.is_lambert() && point.shading.normal == normal) {
        // The same share of every photon; that it arrived at this side its normal says.
        if (wo.z <= 0) return estimate;
        factor = bsdf.f_cos(wo, vec3(0, 0, 1));
        sum = sum_over_disc(map, settings, disc, scratch, [&](const PhotonPayload& photon, float weight, float) {
            const Rgb reflected = weight * photon.power_w;
            estimate.radiance += reflected;
            estimate.delta_radiance += photon.all_delta() ? reflected : Rgb(0);
        });
    } else {
        std::optional<ScatteredSum> scattered;  // most discs of a sparse map hold nothing
        sum = sum_over_disc(map, settings, disc, scratch, [&](const PhotonPayload& photon, float weight, float side) {
            if (!scattered) scattered.emplace(point, bsdf, wo);
            scattered->add(photon, weight, side);
        });
        if (scattered) scattered->finish(estimate);
    }
    estimate.radiance *= factor * sum.scale_per_m2;
    estimate.delta_radiance *= factor * sum.scale_per_m2;
    estimate.photons = sum.photons;
    estimate.radius_m = sum.radius_m;
    return estimate;
}

Rgb estimate_irradiance(const PhotonMap& map, const EstimateSettings& settings, const vec3& position,
                        const vec3& normal, uint32_t most_scatterings, Neighbours& scratch, uint32_t turn) {
    const Disc disc{position, normal, false, most_scatterings, turn};
    Rgb irradiance(0);
    const DiscSum sum =
        sum_over_disc(map, settings, disc, scratch,
                      [&](const PhotonPayload& photon, float weight, float) { irradiance += weight * photon.power_w; });
    return irradiance * sum.scale_per_m2;
}

}  // namespace photond
