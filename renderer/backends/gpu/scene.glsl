// The scene as shaders see it: its geometry, materials and textures (descriptor set 1), and what it needs.
// CPU twin: scene/scene.h. Filled by DeviceScene (device_scene.h), which also gives the constants.
#ifndef PHOTOND_SCENE_GLSL
#define PHOTOND_SCENE_GLSL

#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/scene_bindings.h"
#include "renderer/backends/gpu/scene_shared.h"

// Needs (scene/needs.h): what is not needed is not compiled. Methods' own constants begin at 32.
layout(constant_id = 0) const bool NEEDS_INSTANCES = true;  // some instance has a transform
layout(constant_id = 1) const bool NEEDS_ALPHA = true;
layout(constant_id = 2) const bool NEEDS_NORMAL_MAPS = true;
layout(constant_id = 3) const bool NEEDS_BASE_COLOR_TEXTURES = true;
layout(constant_id = 4) const bool NEEDS_MATERIAL_TEXTURES = true;
layout(constant_id = 5) const bool NEEDS_EMISSION_TEXTURES = true;
layout(constant_id = 6) const bool NEEDS_VERTEX_COLORS = true;
layout(constant_id = 7) const bool ONLY_LAMBERT = false;
layout(constant_id = 8) const bool NEEDS_TRANSMISSION = true;
layout(constant_id = 9) const bool NEEDS_SOLID_GLASS = true;
layout(constant_id = 10) const bool NEEDS_ENVIRONMENT = true;
layout(constant_id = 11) const bool NEEDS_AREA_LIGHTS = true;
layout(constant_id = 12) const bool NEEDS_PUNCTUAL_LIGHTS = true;
layout(constant_id = 13) const bool NEEDS_UNLIT = true;
layout(constant_id = 14) const bool NEEDS_DELTA = true;
layout(constant_id = 15) const bool NEEDS_GLOSSY = true;
layout(constant_id = 16) const bool NEEDS_LIGHT_GROUPS = true;  // directional lights or an environment
layout(constant_id = 17) const bool NEEDS_SMOOTH_NORMALS = true;

layout(set = SCENE_SET, binding = SCENE_CONSTANTS_BINDING, scalar) restrict readonly buffer SceneConstantsBuffer {
    SceneConstants scene_constants;
};
layout(set = SCENE_SET, binding = TRIANGLES_BINDING, scalar) restrict readonly buffer SceneTriangles {
    uvec3 scene_triangles[];
};
layout(set = SCENE_SET, binding = POSITIONS_BINDING, scalar) restrict readonly buffer ScenePositions {
    vec3 scene_positions[];
};
layout(set = SCENE_SET, binding = ATTRIBUTES_BINDING, scalar) restrict readonly buffer SceneAttributes {
    float scene_attributes[];
};
layout(set = SCENE_SET, binding = MESHES_BINDING, scalar) restrict readonly buffer SceneMeshes {
    MeshRecord scene_meshes[];
};
layout(set = SCENE_SET, binding = INSTANCES_BINDING, scalar) restrict readonly buffer SceneInstances {
    InstanceRecord scene_instances[];
};
layout(set = SCENE_SET, binding = MATERIALS_BINDING, scalar) restrict readonly buffer SceneMaterials {
    MaterialRecord scene_materials[];
};
layout(set = SCENE_SET, binding = TEXTURES_BINDING, scalar) restrict readonly buffer SceneTextures {
    TextureRecord scene_textures[];
};
layout(set = SCENE_SET, binding = TEXELS_BINDING, scalar) restrict readonly buffer SceneTexels {
    uint scene_texels[];
};

bool has_flag(uint flags, uint flag) { return (flags & flag) != 0u; }

uint mesh_of(uint instance) { return scene_instances[instance].mesh; }
uint material_of(uint instance) { return scene_meshes[mesh_of(instance)].material; }

/// Whether the instance has a transform: not where the scene has none at all.
bool is_transformed(uint instance) {
    return NEEDS_INSTANCES && !has_flag(scene_instances[instance].flags, INSTANCE_IDENTITY);
}
bool flips_orientation(uint instance) {
    return NEEDS_INSTANCES && has_flag(scene_instances[instance].flags, INSTANCE_FLIPS_ORIENTATION);
}

/// Vertices of a triangle, counted within its mesh.
uvec3 triangle_corners(uint mesh, uint triangle) {
    return scene_triangles[scene_meshes[mesh].first_triangle + triangle];
}

/// An attribute of a vertex; `first`: the mesh's normals, tangents, uv[] or colors, which is not NO_ATTRIBUTE.
vec2 attribute_vec2(uint first, uint stride, uint vertex) {
    const uint i = first + vertex * stride;
    return vec2(scene_attributes[i], scene_attributes[i + 1]);
}
vec3 attribute_vec3(uint first, uint stride, uint vertex) {
    const uint i = first + vertex * stride;
    return vec3(scene_attributes[i], scene_attributes[i + 1], scene_attributes[i + 2]);
}
vec4 attribute_vec4(uint first, uint stride, uint vertex) {
    const uint i = first + vertex * stride;
    return vec4(scene_attributes[i], scene_attributes[i + 1], scene_attributes[i + 2], scene_attributes[i + 3]);
}

/// Three corners of a triangle in world space.
struct TriangleCorners {
    vec3 p[3];
};
TriangleCorners world_triangle(uint instance, uint triangle) {
    const uint mesh = mesh_of(instance);
    const uvec3 corner = scene_meshes[mesh].first_vertex + triangle_corners(mesh, triangle);
    TriangleCorners corners;
    for (int i = 0; i < 3; ++i) corners.p[i] = scene_positions[corner[i]];
    if (is_transformed(instance)) {
        const mat4x3 to_world = scene_instances[instance].to_world;
        for (int i = 0; i < 3; ++i) corners.p[i] = to_world * vec4(corners.p[i], 1.0);
    }
    return corners;
}

#endif
