#pragma once
// BSDFs on the GPU, asked in bulk.

#include "renderer/transport/bsdf.h"
#include "tests/support/gpu_twin.h"

namespace photond::test {

enum class BsdfPart : uint32_t { Whole, Specular, Rough };

/// A BSDF as a test makes it.
struct BsdfCase {
    Bsdf::Parameters parameters;
    BsdfPart part = BsdfPart::Whole;
    float glossy_threshold = 0;
    TransportMode mode = TransportMode::Radiance;

    Bsdf make() const {
        const Bsdf bsdf = Bsdf::layered(parameters);
        return part == BsdfPart::Whole      ? bsdf
               : part == BsdfPart::Specular ? bsdf.specular_part(glossy_threshold)
                                            : bsdf.rough_part(glossy_threshold);
    }
};

/// A question about one of the cases; in the layout the shaders read.
struct BsdfQuery {
    uint32_t bsdf_case;
    vec3 wo;
    vec3 w;  // a direction to evaluate, or three numbers to sample by: u_lobe, u
};

/// What a BSDF says of itself.
struct BsdfTraits {
    Rgb albedo;
    float refraction_eta;
    uint32_t scatters, is_lambert, has_non_delta, has_delta, has_non_delta_transmission, is_diffuse;
};

/// Bsdf's GLSL twin.
class GpuBsdfs {
public:
    GpuBsdfs();

    std::vector<BsdfValue> evaluate(std::span<const BsdfCase> cases, std::span<const BsdfQuery> queries) const;
    std::vector<BsdfSample> sample(std::span<const BsdfCase> cases, std::span<const BsdfQuery> queries) const;
    std::vector<BsdfTraits> traits(std::span<const BsdfCase> cases) const;

private:
    PartOfScene tables_;
    Twin evaluate_, sample_, traits_;
};

}  // namespace photond::test
