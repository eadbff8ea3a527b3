// GLSL twin of make_bsdf() (transport/bsdf.h): a material at a hit as its lobes.
#ifndef PHOTOND_BSDF_MATERIAL_GLSL
#define PHOTOND_BSDF_MATERIAL_GLSL

#include "renderer/transport/bsdf.glsl"
#include "renderer/transport/surface.glsl"

/// The scattering at a hit. `outside_ior`: index of the medium on the outer side of a solid's surface (1 unless it lies
/// in another solid), whichever side is looked at.
Bsdf make_bsdf(ShadingPoint point, float outside_ior) {
    const uint material = point.material;
    const vec3 geometric_normal = to_local(point.shading, point.geometric_normal);
    if (ONLY_LAMBERT) return bsdf_lambert(geometric_normal, scene_materials[material].base_color);
    if (NEEDS_UNLIT && has_flag(scene_materials[material].flags, MATERIAL_UNLIT)) return bsdf_nothing();
    const vec3 base_color = surface_base_color(point.instance, point.triangle, point.u, point.v).rgb;

    BsdfParameters p;
    p.geometric_normal = geometric_normal;
    p.base_color = clamp(base_color, vec3(0.0), vec3(1.0));  // vertex colours may exceed 1, reflectance may not
    p.metallic = scene_materials[material].metallic;
    p.roughness = scene_materials[material].roughness;
    p.specular = scene_materials[material].specular;
    p.transmission = scene_materials[material].transmission;
    p.specular_color = scene_materials[material].specular_color;
    if (NEEDS_MATERIAL_TEXTURES) {
        const uint mesh = mesh_of(point.instance);
        const vec4 metallic_roughness = sample_reference(mesh, scene_materials[material].metallic_roughness_texture,
                                                         point.triangle, point.u, point.v, false);
        p.metallic *= metallic_roughness.z;
        p.roughness *= metallic_roughness.y;
        p.specular *= sample_reference(mesh, scene_materials[material].specular_texture, point.triangle, point.u,
                                       point.v, false).w;
        p.transmission *= sample_reference(mesh, scene_materials[material].transmission_texture, point.triangle,
                                           point.u, point.v, false).x;
        p.specular_color *= sample_reference(mesh, scene_materials[material].specular_color_texture, point.triangle,
                                             point.u, point.v, true).rgb;
    }
    if (p.metallic == 0.0 && p.specular == 0.0 && p.transmission == 0.0)
        return bsdf_lambert(geometric_normal, p.base_color);
    p.ior = scene_materials[material].ior;
    p.solid = has_flag(scene_materials[material].flags, MATERIAL_SOLID);
    // An index of 0 asks for a reflectance of 1 (KHR_materials_ior), which eta = 0 gives.
    const bool opaque = !(p.ior > 0.0 && outside_ior > 0.0);
    p.eta = opaque ? 0.0 : point.front_side ? p.ior / outside_ior : outside_ior / p.ior;
    return bsdf_layered(p);
}
Bsdf make_bsdf(ShadingPoint point) { return make_bsdf(point, 1.0); }

#endif
