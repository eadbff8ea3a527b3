#pragma once
// A scene ready to be rendered: world-space meters, every index validated, triangles only. Immutable once finished.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer/core/memory_budget.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/light.h"
#include "renderer/scene/material.h"
#include "renderer/scene/needs.h"

namespace photond {

/// Indexed triangles with one material, in the space of the instances that use it. Attribute arrays are empty or hold
/// one element a vertex. A mesh used by one instance only is stored in world space.
struct Mesh {
    std::vector<vec3> positions;
    std::vector<vec3> normals;   // unit; empty: flat shading
    std::vector<vec4> tangents;  // xyz unit, w = handedness; only where a normal map needs them
    std::vector<vec2> uv[2];
    std::vector<vec4> colors;  // linear
    std::vector<uvec3> triangles;
    uint32_t material = 0;

    uint64_t bytes() const;
};

/// One placing of a mesh.
struct Instance {
    uint32_t mesh = 0;
    bool identity = true;            // the mesh is in world space already
    mat4x3 to_world{1.0f};           // columns: three axes and the translation
    mat3 normal_to_world{1.0f};      // inverse transpose of the linear part
    bool flips_orientation = false;  // negative determinant: geometric normals from the cross product are negated
};

struct Environment {
    EnvironmentMap map;
    float scale = 1;
    float rotation = 0;  // radians about +Y, counter-clockwise seen from above
};

/// When a scene is shown: at a time of one of its rig's animations; of none, at rest.
struct Moment {
    std::optional<uint32_t> animation;
    double time_s = 0;

    bool operator==(const Moment&) const = default;
};

struct Rig;       // rig.h
struct PosedRig;  // pose.h

struct Scene {
    std::string name;
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<PunctualLight> punctual_lights;
    std::vector<Camera> cameras;  // depth-first order of the default scene; without those scaled to nothing now
    std::optional<Environment> environment;

    // What moves, and how it lies now (pose.h).
    std::shared_ptr<const Rig> rig;  // null: nothing moves
    std::shared_ptr<const PosedRig> posed;
    Moment moment;

    // Derived by finish_scene().
    std::vector<TriangleLight> triangle_lights;
    Bounds3 bounds;  // world space less `origin`
    Needs needs;
    std::optional<Camera> inside_view;  // at rest, where there is no camera and all is dark without: inside_view.h
    dvec3 origin{0};  // added to every position to get the file's coordinates; not 0 when the scene lies far away
    uint64_t triangle_count = 0;  // instances counted
    uint64_t vertex_count = 0;    // stored
    uint64_t file_bytes = 0;
    std::vector<std::string> warnings;

    /// Bytes held by geometry and textures, by structure name.
    void account(MemoryBudget& budget) const;
};

/// Derives lights, bounds and needs, after which only pose_scene() changes the scene.
void finish_scene(Scene& scene);
/// Derives them again where the scene's shape changed. `other_materials`: they or what uses them changed too, and what
/// the scene needs may follow.
void finish_again(Scene& scene, bool other_materials);

/// The camera of that name, the first camera when the name is empty, else the inside view where there is one, else one
/// framed on the bounds. Of an animated
/// scene the first is the first that looks at rest, and bounds are those at rest and at some moments of the animation
/// together (framing.h), so that both are the same at every moment. Throws ErrorCode::UnknownName, with the nearest
/// known name, when there is none of that name, and ErrorCode::BadScene, at the node, when that is scaled to nothing at
/// this moment.
Camera find_camera(const Scene& scene, const std::string& name);

/// Three corners of a triangle in world space.
struct TriangleCorners {
    vec3 p[3];
};
TriangleCorners world_triangle(const Scene& scene, uint32_t instance, uint32_t triangle);

}  // namespace photond
