#include "renderer/photons/gather_distribution.h"

#include <algorithm>

#include "renderer/photons/radiance_estimate.h"
#include "renderer/transport/sampling.h"

namespace photond {

namespace {

/// The number pair that sample_unit_disk() takes to this point of the disc. [Shirley and Chiu 1997], inverted.
vec2 square_of_unit_disk(const vec2& d) {
    const float r = glm::length(d);
    if (r == 0) return vec2(0.5f);
    const bool wide = std::fabs(d.x) > std::fabs(d.y);
    const float radius = std::copysign(r, wide ? d.x : d.y);
    // The angle against the axis of the quarter the point lies in, in [-pi/4, pi/4].
    const float phi = wide ? std::atan(d.y / d.x) : std::atan(d.x / d.y);
    const float other = radius * phi * (4 / kPi);
    const vec2 square = wide ? vec2(radius, other) : vec2(other, radius);
    return glm::clamp(0.5f * square + 0.5f, vec2(0), vec2(0x1.fffffep-1f));
}

uint32_t bin_of(const vec3& wi) {
    constexpr float kSide = GatherDistribution::kSide;
    const vec2 place = square_of_unit_disk(vec2(wi)) * kSide;
    return static_cast<uint32_t>(place.y) * GatherDistribution::kSide + static_cast<uint32_t>(place.x);
}

}  // namespace

GatherDistribution::GatherDistribution(const PhotonMap& map, const ShadingPoint& point, uint32_t most_scatterings,
                                       Neighbours& scratch) {
    map.find(point.position, scratch);
    std::array<float, size_t{kSide} * kSide> power{};
    for (const Neighbours::Found& found : scratch.found) {
        const PhotonPayload& photon = map.payload(found.index);
        if (photon.scatterings() > most_scatterings) continue;
        if (glm::dot(photon.normal(), point.geometric_normal) < kDiscCosine) continue;
        const vec3 wi = point.shading.to_local(photon.wi_world());
        if (wi.z > 0) power[bin_of(wi)] += mean(photon.power_w);
    }
    for (size_t i = 0; i < power.size(); ++i) cdf_[i + 1] = cdf_[i] + power[i];
    total_ = cdf_.back();
}

float GatherDistribution::photon_pdf_sa(const vec3& wi) const {
    if (empty() || wi.z <= 0) return 0;
    const uint32_t bin = bin_of(wi);
    return (cdf_[bin + 1] - cdf_[bin]) / total_ * (kSide * kSide) * cosine_hemisphere_pdf(wi.z);
}

GatherDistribution::Sample GatherDistribution::sample(const Bsdf& bsdf, const vec3& wo, float u_lobe,
                                                      const vec2& u) const {
    Sample s;
    const float share = empty() ? 0.0f : kPhotonShare;
    if (u_lobe < share) {
        const float target = u_lobe / share * total_;
        const auto above = std::upper_bound(cdf_.begin() + 1, cdf_.end() - 1, target);
        const auto bin = static_cast<uint32_t>(above - cdf_.begin() - 1);
        const uvec2 corner(bin % kSide, bin / kSide);
        s.wi = sample_cosine_hemisphere((vec2(corner) + u) / static_cast<float>(kSide));
    } else {
        const float left = std::min((u_lobe - share) / (1 - share), 0x1.fffffep-1f);
        const BsdfSample drawn = bsdf.sample(wo, left, u);
        if (!drawn.valid()) return s;
        s.wi = drawn.wi;
    }
    const BsdfValue value = bsdf.evaluate(wo, s.wi);
    s.pdf_sa = share * photon_pdf_sa(s.wi) + (1 - share) * value.pdf_sa;
    if (s.pdf_sa > 0) s.weight = value.f_cos / s.pdf_sa;
    return s;
}

}  // namespace photond
