// GLSL twin of transport/bsdf_albedo_table.h: E(cos, roughness) = F0 A + F90 B of GGX lobes with Schlick's Fresnel.
#ifndef PHOTOND_BSDF_ALBEDO_TABLE_GLSL
#define PHOTOND_BSDF_ALBEDO_TABLE_GLSL

#include "renderer/backends/gpu/scene_bindings.h"
#include "renderer/core/geometry.glsl"
#include "renderer/scene/delta_shared.h"
#include "renderer/transport/bsdf_albedo_table_shared.h"

/// AlbedoTable::device_data(): (A, B) row by row, then the rows' means.
layout(set = SCENE_SET, binding = TABLES_BINDING, scalar) readonly buffer Tables { vec2 albedo_table[]; };

/// A roughness in [0, 1] as the row the lookups want; below DELTA_ROUGHNESS it stands for a mirror.
float albedo_table_row(float roughness) {
    const float least = sqrt(DELTA_ROUGHNESS);
    return roughness < DELTA_ROUGHNESS
               ? ALBEDO_TABLE_MIRROR_ROW
               : (sqrt(roughness) - least) / (1.0 - least) * float(ALBEDO_TABLE_ROWS - 1);
}

struct AlbedoTableCell {
    uint index;
    float fraction;
};
AlbedoTableCell albedo_table_cell(float position, uint nodes) {
    const uint index = min(uint(position), nodes - 2);
    return AlbedoTableCell(index, position - float(index));
}

/// (A, B) at `cos_theta` in [0, 1].
vec2 albedo_table_directional(float cos_theta, float row) {
    if (row < 0) {
        const float m = 1.0 - cos_theta, schlick = sqr(sqr(m)) * m;
        return vec2(1.0 - schlick, schlick);
    }
    const AlbedoTableCell r = albedo_table_cell(row, ALBEDO_TABLE_ROWS);
    const AlbedoTableCell c =
        albedo_table_cell(sqrt(sqrt(cos_theta)) * float(ALBEDO_TABLE_COLUMNS - 1), ALBEDO_TABLE_COLUMNS);
    const uint low = r.index * ALBEDO_TABLE_COLUMNS + c.index, high = low + ALBEDO_TABLE_COLUMNS;
    return (1 - r.fraction) * ((1 - c.fraction) * albedo_table[low] + c.fraction * albedo_table[low + 1]) +
           r.fraction * ((1 - c.fraction) * albedo_table[high] + c.fraction * albedo_table[high + 1]);
}

/// Cosine-weighted means over the hemisphere of exactly what albedo_table_directional() returns.
vec2 albedo_table_average(float row) {
    if (row < 0) return vec2(20.0 / 21.0, 1.0 / 21.0);
    const AlbedoTableCell r = albedo_table_cell(row, ALBEDO_TABLE_ROWS);
    const uint first = ALBEDO_TABLE_ROWS * ALBEDO_TABLE_COLUMNS;
    return (1 - r.fraction) * albedo_table[first + r.index] + r.fraction * albedo_table[first + r.index + 1];
}

#endif
