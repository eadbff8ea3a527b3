#include "renderer/scene/scene.h"

#include <cassert>

#include "protocol/error.h"
#include "protocol/nearest_name.h"
#include "renderer/scene/inside_view.h"
#include "renderer/scene/pose.h"
#include "renderer/scene/touching_solids.h"
#include "renderer/scene/triangle_lights.h"

namespace photond {

namespace {

template <class T>
uint64_t held_bytes(const std::vector<T>& v) {
    return v.capacity() * sizeof(T);
}

Bounds3 world_bounds(const Scene& scene) {
    Bounds3 bounds;
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        for (const vec3& p : mesh.positions) bounds.extend(instance.identity ? p : instance.to_world * vec4(p, 1));
    }
    return bounds;
}

/// Looks at the whole scene from the front, a little from above, so that its bounding sphere just fits the height: at
/// rest by its bounds, of an animation the same at all its moments. A closed room is looked at from within.
Camera framed_camera(const Scene& scene) {
    constexpr float kYfov = 0.7f;
    if (scene.inside_view) return *scene.inside_view;
    const Bounds3& bounds = scene.posed && scene.posed->framing ? *scene.posed->framing : scene.bounds;
    const dvec3 centre = bounds.empty() ? dvec3(0) : dvec3(bounds.centre());
    double radius = bounds.radius();
    if (!(radius > 0)) radius = 1;  // nothing, or a point: any distance will do
    const dvec3 from = glm::normalize(dvec3(0.25, 0.35, 1.0));
    const dvec3 eye = centre + from * (radius / std::sin(0.5 * double{kYfov}));
    Camera camera = look_at_camera(eye, centre, dvec3(0, 1, 0), kYfov);
    camera.name = "framed";
    return camera;
}

}  // namespace

uint64_t Mesh::bytes() const {
    return held_bytes(positions) + held_bytes(normals) + held_bytes(tangents) + held_bytes(uv[0]) + held_bytes(uv[1]) +
           held_bytes(colors) + held_bytes(triangles);
}

void Scene::account(MemoryBudget& budget) const {
    uint64_t mesh_bytes = held_bytes(meshes);
    for (const Mesh& mesh : meshes) mesh_bytes += mesh.bytes();
    uint64_t texture_bytes = held_bytes(textures);
    for (const Texture& texture : textures) texture_bytes += texture.bytes();
    budget.record("meshes", mesh_bytes);
    budget.record("instances", held_bytes(instances));
    budget.record("materials", held_bytes(materials));
    budget.record("textures", texture_bytes);
    budget.record("lights", held_bytes(punctual_lights) + held_bytes(triangle_lights));
    if (rig) budget.record("rig", rig->bytes() + (posed ? posed->bytes() : 0));
    if (environment) budget.record("environment_map", held_bytes(environment->map.radiance));
}

void finish_scene(Scene& scene) {
    finish_again(scene, true);
    if (!scene.cameras.empty()) return;
    scene.inside_view = find_inside_view(scene);
    if (scene.inside_view) scene.inside_view->name = "framed";
}

void finish_again(Scene& scene, bool other_materials) {
    scene.triangle_count = 0;
    scene.vertex_count = 0;
    for (const Mesh& mesh : scene.meshes) {
        assert(mesh.material < scene.materials.size() && "every mesh has a material");
        scene.vertex_count += mesh.positions.size();
    }
    for (const Instance& instance : scene.instances) {
        assert(instance.mesh < scene.meshes.size() && "every instance has a mesh");
        scene.triangle_count += scene.meshes[instance.mesh].triangles.size();
    }
    overlap_touching_solids(scene);
    scene.bounds = world_bounds(scene);
    scene.triangle_lights = find_triangle_lights(scene);
    if (other_materials)
        scene.needs = find_needs(scene);
    else
        find_light_needs(scene, scene.needs);
}

Camera find_camera(const Scene& scene, const std::string& name) {
    if (scene.posed && !scene.posed->placed.empty()) {
        const PlacedCamera* placed = scene.posed->find(name);
        if (placed && placed->index) return scene.cameras[*placed->index];
        if (placed)
            throw Error(
                ErrorCode::BadScene, "/nodes/" + std::to_string(placed->node),
                "the camera \"" + placed->name + "\" cannot look at this moment: its node is scaled to nothing");
        if (name.empty()) return framed_camera(scene);
    }
    if (name.empty()) return scene.cameras.empty() ? framed_camera(scene) : scene.cameras.front();
    std::vector<std::string> known;
    for (const Camera& camera : scene.cameras) {
        if (camera.name == name) return camera;
        known.push_back(camera.name);
    }
    std::string detail = "the scene has no camera named \"" + name + "\"";
    const std::string nearest = nearest_name(name, known);
    if (!nearest.empty())
        detail += "; did you mean \"" + nearest + "\"?";
    else if (known.empty())
        detail += "; it has no cameras: leave the name out for one framed on its bounds";
    throw Error(ErrorCode::UnknownName, "/camera/name", detail);
}

TriangleCorners world_triangle(const Scene& scene, uint32_t instance_index, uint32_t triangle) {
    const Instance& instance = scene.instances[instance_index];
    const Mesh& mesh = scene.meshes[instance.mesh];
    const uvec3 corner = mesh.triangles[triangle];
    TriangleCorners corners;
    for (int i = 0; i < 3; ++i) {
        const vec3& p = mesh.positions[corner[i]];
        corners.p[i] = instance.identity ? p : instance.to_world * vec4(p, 1);
    }
    return corners;
}

}  // namespace photond
