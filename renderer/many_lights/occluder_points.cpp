#include "renderer/many_lights/occluder_points.h"

#include "renderer/core/rng.h"
#include "renderer/scene/surface_area.h"
#include "renderer/transport/emission.h"
#include "renderer/transport/surface.h"

namespace photond {

namespace {

double area_m2(const TriangleCorners& at) {
    return 0.5 * glm::length(glm::cross(dvec3(at.p[1]) - dvec3(at.p[0]), dvec3(at.p[2]) - dvec3(at.p[0])));
}

template <class Body>
void for_each_triangle(const Scene& scene, const Body& body) {
    for (uint32_t instance = 0; instance < scene.instances.size(); ++instance) {
        const auto triangles = static_cast<uint32_t>(scene.meshes[scene.instances[instance].mesh].triangles.size());
        for (uint32_t triangle = 0; triangle < triangles; ++triangle)
            body(instance, triangle, world_triangle(scene, instance, triangle));
    }
}

/// Point i of the sequence by the plastic number's powers, whose stretches of any length fill the unit square well.
/// [Roberts 2018] The Unreasonable Effectiveness of Quasirandom Sequences.
vec2 plastic_point(uint32_t i) {
    const auto share = [i](double step) { return static_cast<float>(std::fmod(0.5 + (i + 1.0) * step, 1.0)); };
    return {share(0.7548776662466927), share(0.5698402909980532)};
}

}  // namespace

std::vector<gpu::OccluderPoint> make_occluder_points(const Scene& scene, uint32_t count) {
    std::vector<gpu::OccluderPoint> points;
    const double step_m2 = surface_area_m2(scene) / count;
    if (!(step_m2 > 0)) return points;
    points.reserve(count);
    double before_m2 = 0;
    for_each_triangle(scene, [&](uint32_t instance, uint32_t triangle, const TriangleCorners& at) {
        before_m2 += area_m2(at);
        // Point i is at (i + 1/2) steps of the area, all triangles in a row.
        while (points.size() < count && (static_cast<double>(points.size()) + 0.5) * step_m2 <= before_m2) {
            const auto i = static_cast<uint32_t>(points.size());
            vec2 st = plastic_point(i);
            if (st.x + st.y > 1) st = 1.0f - st;
            const bool there = to_unit_float(hash32(i + 1)) < surface_coverage(scene, {instance, triangle, st.x, st.y});
            const vec3 edge1 = at.p[1] - at.p[0], edge2 = at.p[2] - at.p[0];
            points.push_back({at.p[0] + st.x * edge1 + st.y * edge2, there ? unit_cross(edge1, edge2) : vec3(0)});
        }
    });
    // What rounding leaves of the last step.
    while (points.size() < count) points.push_back(points.empty() ? gpu::OccluderPoint{} : points.back());
    return points;
}

}  // namespace photond
