// GLSL twin of transport/medium_stack.h: which solids a ray is in, and what they absorb of the light on its way.
#ifndef PHOTOND_MEDIUM_STACK_GLSL
#define PHOTOND_MEDIUM_STACK_GLSL

#include "renderer/backends/gpu/scene.glsl"
#include "renderer/core/geometry.glsl"

const uint VACUUM = 0xffffffffu;  // MediumStack::kVacuum

/// The solids a ray is in, innermost first (the reverse of the twin's order: nothing here is indexed by a variable),
/// VACUUM beyond. Deeper nesting than four replaces the innermost.
struct MediumStack {
    uvec4 materials;
};

/// Outside of all solids.
MediumStack make_medium_stack() { return MediumStack(uvec4(VACUUM)); }

/// Material of the innermost solid, VACUUM outside of all.
uint medium_stack_top(MediumStack media) { return NEEDS_SOLID_GLASS ? media.materials.x : VACUUM; }

void medium_stack_enter(inout MediumStack media, uint material) {
    const uvec4 m = media.materials;
    const bool full = m.w != VACUUM;
    media.materials = uvec4(material, full ? m.yzw : m.xyz);
}

void medium_stack_leave(inout MediumStack media, uint material) {
    const uvec4 m = media.materials;
    // What lies outside of the innermost occurrence moves in by one.
    if (m.x == material)
        media.materials = uvec4(m.yzw, VACUUM);
    else if (m.y == material)
        media.materials = uvec4(m.x, m.zw, VACUUM);
    else if (m.z == material)
        media.materials = uvec4(m.xy, m.w, VACUUM);
    else if (m.w == material)
        media.materials = uvec4(m.xyz, VACUUM);
}

/// What lies outside of a surface of `material`: seen from within, the solid below its innermost occurrence.
uint medium_stack_outside_of(MediumStack media, uint material, bool seen_from_within) {
    if (seen_from_within) medium_stack_leave(media, material);
    return medium_stack_top(media);
}
/// Index of refraction of what lies outside of a surface: 1 where that is no solid, the material's own where the
/// surface bends nothing, another solid having been entered since.
float medium_stack_outside_ior(MediumStack media, uint material, bool seen_from_within) {
    if (!NEEDS_SOLID_GLASS) return 1.0;
    const bool within_another =
        seen_from_within && media.materials.x != material && any(equal(media.materials.yzw, uvec3(material)));
    const uint outside = within_another ? material : medium_stack_outside_of(media, material, seen_from_within);
    return outside == VACUUM ? 1.0 : scene_materials[outside].ior;
}

/// After a refraction at a surface of `material`: in through its front, out through its back.
void medium_stack_cross(inout MediumStack media, uint material, bool from_front) {
    if (!NEEDS_SOLID_GLASS) return;
    if (from_front)
        medium_stack_enter(media, material);
    else
        medium_stack_leave(media, material);
}

/// Absorption::transmittance: share left of light that travelled `distance` [m] in the innermost solid of the stack;
/// infinite distance: nothing where it absorbs at all.
vec3 transmittance(MediumStack media, float distance) {
    const uint medium = medium_stack_top(media);
    if (medium == VACUUM) return vec3(1.0);
    const float after = scene_materials[medium].attenuation_distance;
    if (!has_flag(scene_materials[medium].flags, MATERIAL_SOLID) || isinf(after)) return vec3(1.0);
    // A channel of 0 is taken as 1e-30, so that the exponent stays finite.
    const vec3 per_m = -log(max(scene_materials[medium].attenuation_color, vec3(1e-30))) / after;
    return mix(vec3(1.0), exp(-per_m * distance), greaterThan(per_m, vec3(0.0)));
}

#endif
