#include "renderer/photons/photon_tracing_scene.h"

namespace photond {

namespace {

/// Whether some place of such a surface may scatter diffusely.
bool may_be_diffuse(const Material& m) {
    return !m.unlit && !is_black(m.base_color) && m.transmission < 1 &&
           (m.metallic < 1 || m.metallic_roughness_texture.used());
}

}  // namespace

bool stores_photons(const Scene& scene, uint32_t instance) {
    const Mesh& mesh = scene.meshes[scene.instances[instance].mesh];
    const Material& material = scene.materials[mesh.material];
    return (is_plain_lambert(material) || base_color_varies(scene, mesh)) && may_be_diffuse(material);
}

PhotonTracingScene::PhotonTracingScene(const Scene& s, const Intersector& first, const Intersector& later,
                                       const EmissionSampler& e, const PhotonTracing& t)
    : scene(s), intersector(first), later_intersector(later), emission(e), tracing(t), absorption(s) {
    shading.reserve(scene.instances.size());
    for (uint32_t index = 0; index < scene.instances.size(); ++index) {
        const Mesh& mesh = scene.meshes[scene.instances[index].mesh];
        shading.push_back({.lambert = is_plain_lambert(scene.materials[mesh.material]),
                           .stores = stores_photons(scene, index),
                           .surface = LambertSurface(scene, index)});
    }
}

}  // namespace photond
