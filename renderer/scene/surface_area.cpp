#include "renderer/scene/surface_area.h"

#include "renderer/scene/scene.h"

namespace photond {

double surface_area_m2(const Scene& scene) {
    double area = 0;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const TriangleCorners triangle = world_triangle(scene, i, t);
            area += 0.5 * double{glm::length(glm::cross(triangle.p[1] - triangle.p[0], triangle.p[2] - triangle.p[0]))};
        }
    }
    return area;
}

}  // namespace photond
