#include "renderer/many_lights/vpl_set.h"

#include <algorithm>

#include "renderer/core/parallel.h"

namespace photond {

RoughOrigin make_rough_origin(const Scene& scene, const ReflectingSurface& at, float threshold) {
    const ShadingPoint surface = make_shading_point(scene, at.hit, -at.wi_world);
    return {surface, make_bsdf(scene, surface, at.outside_ior).rough_part(threshold), at.wi_world};
}

void VplSet::assign(const Scene& scene, const TracedReflections& photons, float connect_threshold) {
    rough.resize(photons.surfaces.size());
    parallel_for(rough.size(), 64,
                 [&](size_t i) { rough[i] = make_rough_origin(scene, photons.surfaces[i], connect_threshold); });
    vpls.clear();
    vpls.reserve(photons.photons.size());
    for (size_t i = 0; i < photons.photons.size(); ++i) {
        const ReflectedPhoton& photon = photons.photons[i];
        if (photon.spread() == ReflectedPhoton::Spread::Beam) continue;
        const bool lambert = photon.spread() == ReflectedPhoton::Spread::Lambert;
        vpls.push_back(
            {.position = photon.position,
             .correction = photon.correction,
             .normal = photon.normal,
             .smooth_normal = photon.smooth_normal,
             .intensity = lambert ? photon.power_w * kInvPi : photons.surfaces[photon.surface].arriving_power_w,
             .surface = lambert ? NO_VPL_SURFACE : photon.surface,
             .scatterings = photon.scatterings(),
             .choice = photons.choices.empty() ? 0.0f : photons.choices[i]});
    }
}

}  // namespace photond
