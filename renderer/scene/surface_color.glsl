// GLSL twin of scene/surface_color.h: material colours that vary over a surface and are needed before any BSDF is.
// Places are named by instance and triangle of its mesh; what a scene does not need is not looked at.
#ifndef PHOTOND_SURFACE_COLOR_GLSL
#define PHOTOND_SURFACE_COLOR_GLSL

#include "renderer/scene/texture.glsl"

/// Texture coordinates of a reference at barycentrics (u, v) of a triangle, transform applied; (0, 0) where the mesh
/// has none in that set.
vec2 texture_coordinates(uint mesh, TextureRefRecord reference, uint triangle, float u, float v) {
    const uint uv = reference.uv_set == 0u ? scene_meshes[mesh].uv[0] : scene_meshes[mesh].uv[1];
    vec2 st = vec2(0.0);
    if (uv != NO_ATTRIBUTE) {
        const uvec3 corner = triangle_corners(mesh, triangle);
        const uint stride = scene_meshes[mesh].attribute_stride;
        st = (1.0 - u - v) * attribute_vec2(uv, stride, corner.x) + u * attribute_vec2(uv, stride, corner.y) +
             v * attribute_vec2(uv, stride, corner.z);
    }
    return vec2(dot(reference.row_u, vec3(st, 1.0)), dot(reference.row_v, vec3(st, 1.0)));
}

/// A reference's texture at a place; 1 where there is none.
vec4 sample_reference(uint mesh, TextureRefRecord reference, uint triangle, float u, float v, bool srgb) {
    if (!texture_used(reference)) return vec4(1.0);
    return sample_texture(reference.texture, texture_coordinates(mesh, reference, triangle, u, v), srgb);
}

/// Emission [W m^-2 sr^-1]: factor x texture x strength; sides and unlit are not looked at.
vec3 surface_emission(uint instance, uint triangle, float u, float v) {
    const uint mesh = mesh_of(instance), material = scene_meshes[mesh].material;
    const vec3 emission = scene_materials[material].emission;
    if (!NEEDS_EMISSION_TEXTURES || max(max(emission.x, emission.y), emission.z) <= 0.0) return emission;
    return emission *
           sample_reference(mesh, scene_materials[material].emission_texture, triangle, u, v, true).rgb;
}

/// Base colour (rgb) and alpha of the material: factor x texture x vertex colour.
vec4 surface_base_color(uint instance, uint triangle, float u, float v) {
    const uint mesh = mesh_of(instance), material = scene_meshes[mesh].material;
    vec4 color = vec4(scene_materials[material].base_color, scene_materials[material].alpha);
    if (NEEDS_BASE_COLOR_TEXTURES)
        color *= sample_reference(mesh, scene_materials[material].base_color_texture, triangle, u, v, true);
    if (NEEDS_VERTEX_COLORS) {
        const uint colors = scene_meshes[mesh].colors;
        if (colors != NO_ATTRIBUTE) {
            const uvec3 corner = triangle_corners(mesh, triangle);
            const uint stride = scene_meshes[mesh].attribute_stride;
            color *= (1.0 - u - v) * attribute_vec4(colors, stride, corner.x) +
                     u * attribute_vec4(colors, stride, corner.y) + v * attribute_vec4(colors, stride, corner.z);
        }
    }
    return color;
}

/// Share of rays that meet the surface here: opaque 1; masked 0 or 1; blended its alpha.
float surface_coverage(uint instance, uint triangle, float u, float v) {
    if (!NEEDS_ALPHA) return 1.0;
    const uint material = material_of(instance), mode = scene_materials[material].alpha_mode;
    if (mode == ALPHA_OPAQUE) return 1.0;
    const float alpha = surface_base_color(instance, triangle, u, v).w;
    if (mode == ALPHA_MASK) return alpha >= scene_materials[material].alpha_cutoff ? 1.0 : 0.0;
    return clamp(alpha, 0.0, 1.0);
}

#endif
