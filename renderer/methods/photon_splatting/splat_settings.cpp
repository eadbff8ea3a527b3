#include "renderer/methods/photon_splatting/splat_settings.h"

#include <cmath>

#include "renderer/scene/scene.h"
#include "renderer/scene/surface_area.h"

namespace photond {

namespace {

// Side of a splat over the radius of the scene's bounding sphere. Measured in the Cornell box: see the class's page.
constexpr float kSizeRelative = 0.2f;
// Beams' radius over that of connections, where both are: of all, and the most of those that a pilot sizes. Measured on
// cornell-box-glass as for BeamSizes: relative_mse with 0.25 0.0126, with 0.5 0.0104, with 1 the same and more bias.
constexpr float kBeamShare = 0.25f, kMostBeamShare = 0.5f;
constexpr float kDepthRadii = 10;  // of a frustum before and beyond the hit: at two a plain floor loses 6 %

Kernel kernel_of(SplatFilter filter) {
    switch (filter) {
        case SplatFilter::Box: return Kernel(KernelShape::Constant);
        case SplatFilter::Tent: return Kernel(KernelShape::Cone, 1.0f);
        case SplatFilter::Gaussian: return Kernel(KernelShape::Gaussian);
    }
    return Kernel();
}

}  // namespace

SplatSettings::SplatSettings(const PhotonSplattingParams& params, const Scene& scene)
    : connects(params.connects()),
      normalised(params.weighting == SplatWeighting::Normalised),
      visibility(params.visibility),
      filter(kernel_of(params.filter)),
      // A scene without extent has nothing to splat on, but a splat wants a size.
      radius_m(0.5f * params.splat_size_m.value_or(std::max(
                          params.splat_size_relative.value_or(kSizeRelative) * scene.bounds.radius(), 1e-20f))),
      beam_radius_m(radius_m * (!connects              ? 1
                                : params.adaptive_size ? kMostBeamShare
                                                       : kBeamShare)),
      step_back_m(params.step_back_m.value_or(0)),
      step_back_radii(params.step_back_m ? 0 : kDepthRadii),
      depth_m(params.splat_depth_m.value_or(step_back_m)),
      depth_radii(params.splat_depth_m ? 0 : step_back_radii + kDepthRadii),
      shrink_alpha(params.shrinks() ? params.alpha : 1.0f),
      shadow_resolution(params.shadow_resolution),
      surface_area_m2(normalised ? std::max(static_cast<float>(photond::surface_area_m2(scene)), 1e-30f) : 1.0f) {}

float SplatSettings::shrink(uint32_t pass) const {
    if (shrink_alpha == 1) return 1;
    const double i = static_cast<double>(pass) + 1, alpha = double{shrink_alpha};
    return static_cast<float>(std::exp(0.5 * (std::lgamma(i + alpha) - std::lgamma(1 + alpha) - std::lgamma(i + 1))));
}

}  // namespace photond
