// GLSL twin of BsdfEvaluator::lobe_albedos(). Define LOBE_ALBEDO_TABLE_BINDING (of set 0) before.
#ifndef PHOTOND_BSDF_LOBE_ALBEDOS_GLSL
#define PHOTOND_BSDF_LOBE_ALBEDOS_GLSL

#include "renderer/transport/bsdf.glsl"
#include "renderer/transport/bsdf_lobe_albedos_shared.h"

/// AlbedoTable::unraised(), as its device_data() has it.
layout(set = 0, binding = LOBE_ALBEDO_TABLE_BINDING, scalar) readonly buffer LobeAlbedoTable {
    vec2 lobe_albedo_table[];
};

struct LobeAlbedos {
    vec3 diffuse;
    vec3 reflected;    // GGX, about the mirrored direction
    vec3 transmitted;  // by a thin sheet, about the direction straight through
    float alpha;       // of those two
};

/// (A, B) at `cos_theta` of a rough lobe.
vec2 lobe_albedo_factors(float cos_theta, float row) {
    const AlbedoTableCell r = albedo_table_cell(row, ALBEDO_TABLE_ROWS);
    const AlbedoTableCell c =
        albedo_table_cell(sqrt(sqrt(cos_theta)) * float(ALBEDO_TABLE_COLUMNS - 1), ALBEDO_TABLE_COLUMNS);
    const uint low = r.index * ALBEDO_TABLE_COLUMNS + c.index, high = low + ALBEDO_TABLE_COLUMNS;
    return mix(mix(lobe_albedo_table[low], lobe_albedo_table[low + 1u], c.fraction),
               mix(lobe_albedo_table[high], lobe_albedo_table[high + 1u], c.fraction), r.fraction);
}

/// Ggx::directional_albedo() of a solid's interface.
vec3 glass_lobe_albedo(Bsdf bsdf, vec3 to_eye) {
    const vec3 wo = vec3(length(to_eye.xy), 0.0, to_eye.z);
    const Ggx ggx = Ggx(bsdf.alpha);
    const bool within = bsdf.eta < 1.0;
    const uint azimuths = within ? GLASS_ALBEDO_AZIMUTHS_WITHIN : GLASS_ALBEDO_AZIMUTHS;
    const uint caps = within ? GLASS_ALBEDO_CAPS_WITHIN : GLASS_ALBEDO_CAPS;
    const float g1 = ggx_g1_over_cos(ggx, wo);
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < azimuths * caps; ++i) {
        const float azimuth = float(i / caps) + 0.5;
        const float v = (float(i % caps) + fract(0.618034 * azimuth)) / float(caps);
        const vec3 h = ggx_sample_visible(ggx, wo, vec2(0.5 * azimuth / float(azimuths), 1.0 - v * v * v));
        const float cos_h = dot(wo, h);
        const vec3 wi = reflect_direction(wo, h);
        if (wi.z <= 0.0) continue;
        sum += 3.0 * v * v * ggx_g2_over_cosines(ggx, wo, wi) * wi.z / g1 *
               bsdf_glass_reflectance(bsdf, cos_h, fresnel_dielectric(cos_h, bsdf.eta));
    }
    return bsdf.glass * sum / float(azimuths * caps);
}

LobeAlbedos bsdf_lobe_albedos(Bsdf bsdf, vec3 wo) {
    LobeAlbedos albedos = LobeAlbedos(vec3(0.0), vec3(0.0), vec3(0.0), bsdf.alpha);
    if (wo.z <= 0.0) return albedos;
    if (bsdf_is_lambert(bsdf)) albedos.diffuse = bsdf.diffuse;
    if (!bsdf_is_layered(bsdf)) return albedos;
    if (!is_black(bsdf.diffuse)) {
        const vec2 average = albedo_table_average(bsdf.table_row);
        const float passed = 1.0 - (bsdf.coat_f0 * average.x + bsdf.coat_f90 * average.y);
        albedos.diffuse = bsdf.diffuse * ((1.0 - bsdf_coat_albedo(bsdf, wo.z)) * passed);
    }
    if (!bsdf_specular_delta(bsdf)) {
        const vec2 ab = lobe_albedo_factors(wo.z, bsdf.table_row);
        albedos.reflected = bsdf.specular_f0 * ab.x + bsdf.specular_f90 * ab.y;
        albedos.transmitted = bsdf_sheet(bsdf) * ((1.0 - bsdf.coat_f0) * ab.x + (1.0 - bsdf.coat_f90) * ab.y);
    }
    if (bsdf_glass(bsdf) > 0.0 && !bsdf_glass_delta(bsdf)) albedos.reflected += glass_lobe_albedo(bsdf, wo);
    return albedos;
}

#endif
