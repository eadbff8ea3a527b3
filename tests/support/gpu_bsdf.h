#pragma once
// BSDFs on the GPU, asked in bulk.

#include "tests/support/bsdf_case.h"
#include "tests/support/gpu_twin.h"

namespace photond::test {

/// What a BSDF says of itself.
struct BsdfTraits {
    Rgb albedo;
    float refraction_eta;
    uint32_t scatters, is_lambert, has_non_delta, has_delta, has_non_delta_transmission, is_diffuse;
};

/// Answers by Bsdf's GLSL twin.
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
