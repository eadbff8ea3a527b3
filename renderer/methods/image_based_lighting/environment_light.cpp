#include "renderer/methods/image_based_lighting/environment_light.h"

#include "renderer/transport/bsdf_evaluator.h"

namespace photond {

void EnvironmentLight::take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) {
    std::vector<Rgb>& direct = image_.of<Layer::Direct>();
    for (const LambertVisiblePoint& point : lambert)
        direct[point.pixel] += point.weight * environment_.reflected_by_white(point.normal);
    for (const VisiblePoint& point : others)
        direct[point.pixel] += point.throughput * reflected(environment_, point.surface.shading, point.rough, point.wo);
}

Rgb EnvironmentLight::reflected(const PrefilteredEnvironment& environment, const Frame& shading, const Bsdf& rough,
                                const vec3& wo) {
    const LobeAlbedos albedos = BsdfEvaluator(rough, wo).lobe_albedos();
    Rgb light = albedos.diffuse * environment.reflected_by_white(shading.normal);
    const float roughness = std::sqrt(albedos.alpha);
    if (!is_black(albedos.reflected))
        light += albedos.reflected * environment.radiance(shading.to_world({-wo.x, -wo.y, wo.z}), roughness);
    if (!is_black(albedos.transmitted))
        light += albedos.transmitted * environment.radiance(shading.to_world(-wo), roughness);
    return light;
}

}  // namespace photond
