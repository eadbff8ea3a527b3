#version 460
// Values of BSDFs for pairs of directions.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "tests/gpu/bsdf.glsl"
#include "tests/gpu/twin.glsl"

layout(set = 0, binding = 0, scalar) readonly buffer Cases { BsdfCase cases[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Queries { BsdfQuery queries[]; };
layout(set = 0, binding = 2, scalar) writeonly buffer Out { BsdfValue values[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const BsdfQuery query = queries[i];
    const BsdfCase c = cases[query.bsdf_case];
    values[i] = bsdf_evaluate(make_case(c), query.wo, query.w, c.mode);
}
