#pragma once
// Sampling of an equirectangular environment by its radiance.

#include <span>
#include <vector>

#include "renderer/core/rgb.h"

namespace photond {

struct Environment;

/// What the density of a direction follows.
enum class EnvironmentDensity : uint8_t {
    Radiance,
    /// The radiance's excess over its mean over the sphere; evenly, where no texel exceeds it [Karlik et al. 2019,
    /// docs/design/sources.md]. For light samples whose every contribution is weighed against a BSDF's
    /// sample at the same point that is always traced: where this density is 0, only that finds the light. With the
    /// same two samples the estimate has less variance, as light samples no longer do what the BSDF's do as well.
    Compensated,
};

/// Directions drawn with a density that is constant over each texel's solid angle and follows the mean radiance there,
/// or its excess. Immutable and thread-safe; borrows the environment.
class EnvironmentSampler {
public:
    /// The map must not be empty.
    explicit EnvironmentSampler(const Environment& environment,
                                EnvironmentDensity density = EnvironmentDensity::Radiance);

    /// Draws a unit direction from a uniform pair; its density [1/sr]. False when the map is black.
    bool sample(vec2 u, vec3& wi, float& pdf_sa) const;
    float pdf(const vec3& wi) const;
    /// Radiance that arrives along -wi [W m^-2 sr^-1]: bilinear between texel centres, scale applied.
    Rgb radiance(const vec3& wi) const;
    /// Mean over the sphere and the channels [W m^-2 sr^-1].
    float mean_radiance() const { return mean_radiance_; }

    // The tables it draws by, for the device's copy (light_tables.h).
    std::span<const float> row_cdf() const { return row_cdf_; }        // height + 1
    std::span<const float> column_cdf() const { return column_cdf_; }  // height rows of width + 1
    /// Cosine of the polar angle of a row's upper edge; row in [0, height].
    float row_edge(uint32_t row) const;

    static uint64_t bytes_for(Size2 size) {
        return size.pixels() == 0 ? 0 : (size.pixels() + 2 * uint64_t{size.height} + 1) * sizeof(float);
    }
    uint64_t bytes() const { return (row_cdf_.capacity() + column_cdf_.capacity()) * sizeof(float); }

private:
    vec2 to_map(const vec3& wi) const;  // (column, row) in [0, 1]^2

    const Environment& environment_;
    std::vector<float> row_cdf_;
    std::vector<float> column_cdf_;
    float mean_radiance_ = 0;
};

}  // namespace photond
