#pragma once
// What surfaces make of the environment by the split sum: each lobe's share of uniform light times the radiance that
// its lobe, looked at straight on, would find.

#include "renderer/eye/specular_walk.h"
#include "renderer/methods/image_based_lighting/prefiltered_environment.h"

namespace photond {

/// Lights visible points where a walk leaves them: the first rough surfaces, for it has followed all that is not. One
/// thread's.
class EnvironmentLight final : public VisiblePointSink {
public:
    /// Borrows both.
    EnvironmentLight(const PrefilteredEnvironment& environment, PassImage& image)
        : environment_(environment), image_(image) {}

    void take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) override;
    /// Radiance towards the eye, unshadowed.
    static Rgb reflected(const PrefilteredEnvironment& environment, const Frame& shading, const Bsdf& rough,
                         const vec3& wo);

private:
    const PrefilteredEnvironment& environment_;
    PassImage& image_;
};

}  // namespace photond
