// The scene's records on the device (device_scene.h uploads them, scene.glsl declares them): read by the C++ compiler
// and by glslang, scalar layout. Their fields are those of scene/scene.h, material.h and texture.h.
#ifndef PHOTOND_SCENE_SHARED_H
#define PHOTOND_SCENE_SHARED_H

#define NO_TEXTURE (-1)
#define NO_ATTRIBUTE 0xffffffffu

// InstanceRecord::flags
#define INSTANCE_IDENTITY 1u
#define INSTANCE_FLIPS_ORIENTATION 2u

// MaterialRecord::flags
#define MATERIAL_SOLID 1u
#define MATERIAL_DOUBLE_SIDED 2u
#define MATERIAL_UNLIT 4u

// MaterialRecord::alpha_mode
#define ALPHA_OPAQUE 0u
#define ALPHA_MASK 1u
#define ALPHA_BLEND 2u

// TextureRecord::wrap_s, wrap_t
#define WRAP_REPEAT 0u
#define WRAP_MIRRORED_REPEAT 1u
#define WRAP_CLAMP_TO_EDGE 2u

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

struct SceneConstants {
    vec3 bounds_min;  // world space; both 0 in an empty scene
    vec3 bounds_max;
    uint instance_count;
    uint material_count;
    float srgb_to_linear[256];  // of 8-bit codes
};

// Attributes are interleaved: what one vertex has lies together. `normals` ... `colors`: where the first vertex's is,
// in floats; NO_ATTRIBUTE where the mesh has none.
struct MeshRecord {
    uint first_vertex;  // triangles count from there
    uint first_triangle;
    uint triangle_count;
    uint material;
    uint attribute_stride;  // floats from one vertex to the next
    uint normals;           // vec3
    uint tangents;          // vec4
    uint uv[2];             // vec2
    uint colors;            // vec4
};

struct InstanceRecord {
    mat4x3 to_world;  // columns: three axes and the translation
    mat3 normal_to_world;
    uint mesh;
    uint flags;
};

struct TextureRefRecord {
    int texture;
    uint uv_set;
    vec3 row_u;
    vec3 row_v;
};

struct MaterialRecord {
    vec3 base_color;
    float alpha;
    vec3 emission;  // factor x strength [W m^-2 sr^-1]
    float metallic;
    float roughness;
    float normal_scale;
    float ior;
    float specular;
    vec3 specular_color;
    float transmission;
    vec3 attenuation_color;
    float attenuation_distance;  // [m]
    uint alpha_mode;
    float alpha_cutoff;
    uint flags;
    TextureRefRecord base_color_texture;
    TextureRefRecord metallic_roughness_texture;
    TextureRefRecord normal_texture;
    TextureRefRecord emission_texture;
    TextureRefRecord specular_texture;
    TextureRefRecord specular_color_texture;
    TextureRefRecord transmission_texture;
};

// Texels are one word each, red in the lowest byte, rows one after the other.
struct TextureRecord {
    uint first_texel;
    uint width;
    uint height;
    uint wrap_s;
    uint wrap_t;
    uint nearest;  // 0 or 1
};

#ifdef __cplusplus
static_assert(sizeof(SceneConstants) == 32 + 1024 && sizeof(MeshRecord) == 40 && sizeof(InstanceRecord) == 92);
static_assert(sizeof(TextureRefRecord) == 32 && sizeof(MaterialRecord) == 92 + 7 * 32 && sizeof(TextureRecord) == 24);
}  // namespace photond::gpu
#endif

#endif
