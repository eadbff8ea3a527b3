// GLSL twin of transport/emission.h: what a surface sends out by itself. surface_coverage() is that of
// scene/surface_color.glsl.
#ifndef PHOTOND_EMISSION_GLSL
#define PHOTOND_EMISSION_GLSL

#include "renderer/scene/surface_color.glsl"

/// Radiance [W m^-2 sr^-1] the material's emission sends from a point towards a direction on the given side of its
/// surface: factor x texture x strength; black at the back unless the material is double-sided. `front`: the direction
/// leaves on the side that the geometric normal points to. Black for unlit materials, which light nothing. Coverage
/// (alpha) is not in it: a ray that hit met a surface.
vec3 emitted_radiance(uint instance, uint triangle, float u, float v, bool front) {
    const uint flags = scene_materials[material_of(instance)].flags;
    if (has_flag(flags, MATERIAL_UNLIT) || !(front || has_flag(flags, MATERIAL_DOUBLE_SIDED))) return vec3(0.0);
    return surface_emission(instance, triangle, u, v);
}

/// KHR_materials_unlit: the constant radiance [W m^-2 sr^-1] an unlit surface shows to the eye, on both sides: base
/// colour x texture x vertex colour. Black for materials that are not unlit.
vec3 unlit_radiance(uint instance, uint triangle, float u, float v) {
    if (!NEEDS_UNLIT || !has_flag(scene_materials[material_of(instance)].flags, MATERIAL_UNLIT)) return vec3(0.0);
    return surface_base_color(instance, triangle, u, v).rgb;
}

#endif
