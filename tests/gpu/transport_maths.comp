#version 460
// The small functions of transport, each of one argument of four numbers.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "renderer/methods/photon_splatting/connect_weight.glsl"
#include "renderer/photons/kernel.glsl"
#include "renderer/transport/fresnel.glsl"
#include "renderer/transport/mis.glsl"
#include "renderer/transport/sampling.glsl"
#include "tests/gpu/twin.glsl"

struct Results {
    vec3 cosine_hemisphere;
    vec2 triangle;
    vec2 fresnel;  // reflectance, cos_t
    vec3 heuristics;
    vec3 tangent, bitangent, offset;
    float connect;
    vec2 kernels[4];  // at q_sq, disc of u
};
layout(set = 0, binding = 0, scalar) readonly buffer Kernels { KernelRecord kernels[4]; };
layout(set = 0, binding = 1, scalar) readonly buffer In { vec4 arguments[]; };  // uniform in [0, 1)
layout(set = 0, binding = 2, scalar) writeonly buffer Out { Results results[]; };

void main() {
    const uint i = flat_index();
    if (i >= count) return;
    const vec4 a = arguments[i];
    Results r;
    r.cosine_hemisphere = sample_cosine_hemisphere(a.xy);
    r.triangle = sample_triangle(a.xy);
    const DielectricFresnel fresnel = fresnel_dielectric(a.x, 2 * a.y);
    r.fresnel = vec2(fresnel.reflectance, fresnel.cos_t);
    r.heuristics = vec3(balance_heuristic(a.x, a.y), power_heuristic(a.x, a.y), area_to_solid_angle_pdf(a.x, a.y, a.z));
    const Frame frame = make_frame(normalize(a.xyz - 0.5));
    r.tangent = frame.tangent;
    r.bitangent = frame.bitangent;
    r.offset = offset_ray_origin(exp2(20 * (a.w - 0.5)) * (a.yzx - 0.5), frame.normal);
    r.connect = connect_factor(4 * sqr(a.x), a.y, sqr(a.z) + 1e-6, a.w);
    for (int k = 0; k < 4; ++k)
        r.kernels[k] = vec2(kernel_evaluate(kernels[k], a.x), kernel_sample_disc(kernels[k], a.y));
    results[i] = r;
}
