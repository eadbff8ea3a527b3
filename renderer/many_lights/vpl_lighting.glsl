// GLSL twin of many_lights/vpl_lighting.h: what one virtual point light brings to one point.
#ifndef PHOTOND_VPL_LIGHTING_GLSL
#define PHOTOND_VPL_LIGHTING_GLSL

#include "renderer/core/rng.glsl"
#include "renderer/gbuffer/split_buffer.glsl"
#include "renderer/many_lights/vpl.glsl"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/gbuffer/receiver.glsl"
#include "renderer/many_lights/vpl_lighting_shared.h"
#include "renderer/many_lights/vpl_set_shared.h"
#include "renderer/photons/photon.glsl"
#include "renderer/transport/photon_scattering.glsl"

/// Of the point's random numbers in a pass.
uint point_key(GBufferPoint point, uint64_t seed, uint pass) {
    return hash32(point.pixel ^ hash32(pass ^ hash32(uint(seed ^ seed >> 32))));
}

/// The geometric normal on the side that a point is lit from out of `position`.
vec3 lit_side(GBufferPoint point, vec3 position) {
    return dot(point.geometric_normal, position - point.position) > 0.0 ? point.geometric_normal
                                                                        : -point.geometric_normal;
}

/// RoughOrigin: scatter_density() of a light's lobes, towards `out_world`.
vec3 vpl_scatter_density(vec3 geometric_normal, VplLobes at, vec3 out_world) {
    Bsdf rough = bsdf_nothing();
    rough.flags = at.flags;
    rough.diffuse = at.diffuse;
    rough.alpha = at.alpha;
    rough.table_row = at.table_row;
    rough.specular_f0 = at.specular_f0;
    rough.specular_f90 = at.specular_f90;
    rough.coat_f0 = at.coat_f0;
    rough.coat_f90 = at.coat_f90;
    rough.tint = vec3(0.0);
    rough.glass = 0.0;
    ShadingPoint surface;
    surface.geometric_normal = geometric_normal;
    surface.smooth_normal = at.smooth_normal;
    return scatter_density(surface, rough, at.wi_world, out_world);
}

/// What is there of a light towards a point, before what depends on either's material.
struct VplConnection {
    vec3 to_light;  // unit
    float gain;     // cos_o / max(B, d^2); 0: nothing
    float cos_x;    // 1 where light from both sides counts
};

VplConnection connect_vpl(Vpl vpl, GBufferPoint point, float clamp_sq_m2) {
    VplConnection connection = VplConnection(vec3(0.0), 0.0, 1.0);
    const vec3 d = vpl.position - point.position;
    const float d_sq = dot(d, d);
    connection.to_light = d * (1.0 / sqrt(max(d_sq, 1e-37)));
    const float cos_o = -dot(vpl.normal, connection.to_light);
    if (!(cos_o > 0.0) || vpl.scatterings > (point.kind & GBUFFER_SCATTERINGS)) return connection;
    if (ONLY_LAMBERT || point.normal != vec3(0.0)) {
        connection.cos_x = dot(point.normal, connection.to_light);
        if (!(connection.cos_x > 0.0 && dot(point.geometric_normal, connection.to_light) > 0.0)) return connection;
    }
    connection.gain = cos_o * clamped_falloff(d_sq, clamp_sq_m2);
    return connection;
}

#ifdef VPL_LOBES_BINDING

layout(set = 0, binding = VPL_LOBES_BINDING, scalar) readonly buffer VplLobesBuffer { VplLobes vpl_lobes[]; };

/// What a light brings to a point if nothing stands between: irradiance [W m^-2] of Lambert points, of others radiance
/// [W m^-2 sr^-1] before the throughput; `receiver` is read of those alone.
vec3 vpl_light(Vpl vpl, GBufferPoint point, Receiver receiver, float clamp_sq_m2) {
    const VplConnection connection = connect_vpl(vpl, point, clamp_sq_m2);
    if (!(connection.gain > 0.0)) return vec3(0.0);
    vec3 light = vpl.intensity;
    if (ONLY_LAMBERT || vpl_is_lambert(vpl)) {
        light *= connection.gain;
        if (vpl.correction != 1.0 && dot(octahedral_decode(16u, vpl.smooth_normal), connection.to_light) < 0.0)
            light *= vpl.correction;
    } else {
        const vec3 d = vpl.position - point.position;
        light *= clamped_falloff(dot(d, d), clamp_sq_m2) *
                 vpl_scatter_density(vpl.normal, vpl_lobes[vpl.surface], -connection.to_light);
    }
    if (is_general(point))
        return light * bsdf_f_cos(receiver.rough, receiver.wo, to_local(receiver.surface.shading, connection.to_light));
    return light * connection.cos_x;
}

#endif

#endif
