#include "renderer/transport/bsdf_albedo_table.h"

#include "renderer/transport/fresnel.h"
#include "renderer/transport/microfacet.h"

namespace photond {

namespace {

/// Visible normals on a midpoint grid: each weighs G2 / G1(wo), split by Schlick's curve. Half the azimuths are enough,
/// as the lobe is symmetric about the plane of incidence.
vec2 integrate(float cos_theta, float alpha) {
    if (alpha == 0.0f) {
        const float weight = schlick_weight(cos_theta);
        return {1.0f - weight, weight};
    }
    constexpr int kAzimuths = 16, kCaps = 32;
    const Ggx ggx{alpha};
    const vec3 wo(std::sqrt(1.0f - sqr(cos_theta)), 0, cos_theta);
    const float g1_over_cos = ggx.g1_over_cos(wo);
    vec2 sum(0);
    for (int i = 0; i < kAzimuths; ++i)
        for (int j = 0; j < kCaps; ++j) {
            const vec2 u((static_cast<float>(i) + 0.5f) / (2 * kAzimuths), (static_cast<float>(j) + 0.5f) / kCaps);
            const vec3 h = ggx.sample_visible(wo, u);
            const vec3 wi = reflect_direction(wo, h);
            if (wi.z <= 0) continue;
            const float weight = ggx.g2_over_cosines(wo, wi) * wi.z / g1_over_cos;
            const float schlick = schlick_weight(glm::dot(wo, h));
            sum += weight * vec2(1.0f - schlick, schlick);
        }
    return sum / static_cast<float>(kAzimuths * kCaps);
}

}  // namespace

AlbedoTable::AlbedoTable() {
    // Not in parallel: a thread that waited here could be handed a task that needs this very table.
    for (size_t r = 0; r < kRows; ++r) {
        const float roughness = static_cast<float>(r) / (kRows - 1);
        for (size_t c = 0; c < kColumns; ++c) {
            // The limit at the horizon is taken just above it.
            const float t = std::max(static_cast<float>(c) / (kColumns - 1), 1e-3f);
            directional_[r][c] = integrate(sqr(t), sqr(roughness));
        }
        // Mean of E 2 cos dcos = E 4 t^3 dt with t = sqrt(cos), of the linear interpolant exactly: over [0, 1] steps of
        // h, node k weighs the integral of its hat function times 4 t^3.
        dvec3 sum(0);
        const double h = 1.0 / (kColumns - 1);
        for (size_t c = 0; c + 1 < kColumns; ++c) {
            const double a = static_cast<double>(c) * h, b = a + h;
            const double m3 = std::pow(b, 4) - std::pow(a, 4);          // integral of 4 t^3
            const double m4 = 0.8 * (std::pow(b, 5) - std::pow(a, 5));  // integral of 4 t^4
            const double right = (m4 - a * m3) / h, left = m3 - right;
            sum += left * dvec3(vec3(directional_[r][c], 0)) + right * dvec3(vec3(directional_[r][c + 1], 0));
        }
        average_[r] = vec2(sum);
    }
}

const AlbedoTable& AlbedoTable::get() {
    static const AlbedoTable table;
    return table;
}

}  // namespace photond
