#pragma once
// Where the light comes from, as the photons about a point tell: a density of directions for gather rays.
//
// The hemisphere is a grid of bins of equal projected solid angle (the concentric square of the cosine lobe); a bin's
// weight is the power of the photons that came through it. Mixed with the BSDF's own density, so that no direction is
// missed and no weight grows past 1 / share.
//
// [Jensen 1995] Importance Driven Path Tracing using the Photon Map. Eurographics Workshop on Rendering.

#include <array>

#include "renderer/photons/photon_map.h"
#include "renderer/transport/bsdf.h"

namespace photond {

class GatherDistribution {
public:
    static constexpr uint32_t kSide = 8;         // bins along each side of the square
    static constexpr float kPhotonShare = 0.5f;  // of the directions drawn by photons; the rest by the BSDF

    /// Looks at the photons about the point (map.find); those refused by normal (60 degrees) do not count. Without any
    /// the density is the BSDF's alone.
    GatherDistribution(const PhotonMap& map, const ShadingPoint& point, uint32_t most_scatterings, Neighbours& scratch);

    struct Sample {
        vec3 wi{0, 0, 1};  // local to point.shading
        Rgb weight{0};     // f |cos| / pdf
        float pdf_sa = 0;  // 0: drop it
    };
    /// Draws a direction for light that `bsdf` (without delta lobes) scatters towards `wo`; one-sample mixture with the
    /// balance heuristic.
    Sample sample(const Bsdf& bsdf, const vec3& wo, float u_lobe, const vec2& u) const;

    /// Density [1/sr] of the photons' part alone.
    float photon_pdf_sa(const vec3& wi) const;
    bool empty() const { return !(total_ > 0); }

private:
    std::array<float, kSide * kSide + 1> cdf_{};  // cumulative power
    float total_ = 0;
};

}  // namespace photond
