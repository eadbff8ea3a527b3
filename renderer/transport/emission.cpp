#include "renderer/transport/emission.h"

#include "renderer/scene/scene.h"
#include "renderer/scene/surface_color.h"

namespace photond {

namespace {

const Mesh& mesh_of(const Scene& scene, const SurfacePoint& point) {
    return scene.meshes[scene.instances[point.instance].mesh];
}

}  // namespace

Rgb emitted_radiance(const Scene& scene, const SurfacePoint& point, bool front) {
    const Mesh& mesh = mesh_of(scene, point);
    const Material& material = scene.materials[mesh.material];
    if (material.unlit || !(front || material.double_sided)) return Rgb(0);
    return surface_emission(scene, mesh, point.triangle, point.u, point.v);
}

Rgb unlit_radiance(const Scene& scene, const SurfacePoint& point) {
    const Mesh& mesh = mesh_of(scene, point);
    if (!scene.materials[mesh.material].unlit) return Rgb(0);
    return Rgb(surface_base_color(scene, mesh, point.triangle, point.u, point.v));
}

float surface_coverage(const Scene& scene, const SurfacePoint& point) {
    return surface_coverage(scene, mesh_of(scene, point), point.triangle, point.u, point.v);
}

}  // namespace photond
