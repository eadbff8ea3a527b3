#include "renderer/transport/light_triangle.h"

#include "renderer/scene/scene.h"

namespace photond {

LightTriangle make_light_triangle(const Scene& scene, const TriangleLight& light) {
    const TriangleCorners corners = world_triangle(scene, light.instance, light.triangle);
    const Instance& instance = scene.instances[light.instance];
    const Material& material = scene.materials[scene.meshes[instance.mesh].material];
    LightTriangle t{};
    t.corner = corners.p[0];
    t.edge1 = corners.p[1] - corners.p[0];
    t.edge2 = corners.p[2] - corners.p[0];
    const dvec3 cross = glm::cross(dvec3(t.edge1), dvec3(t.edge2));
    t.normal = vec3(cross / (instance.flips_orientation ? -glm::length(cross) : glm::length(cross)));
    t.varies = material.emission_texture.used() || material.alpha_mode != AlphaMode::Opaque;
    return t;
}

}  // namespace photond
