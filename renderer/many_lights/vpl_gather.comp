#version 460
// Reflected photons, in their order, as virtual point lights, a thread a light: CPU twin VplSet::assign().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/many_lights/vpl_set_shared.h"
#include "renderer/photons/reflected_photon_shared.h"
#include "renderer/transport/bsdf_material.glsl"

layout(local_size_x = VPL_SET_GROUP) in;
layout(push_constant, scalar) uniform Push { VplGatherPush push; };
layout(set = 0, binding = 0, scalar) readonly buffer State { uint state[REFLECTION_STATE_WORDS]; };
layout(set = 0, binding = 1, scalar) readonly buffer Photons { ReflectedPhotonRecord photons[]; };
layout(set = 0, binding = 2, scalar) readonly buffer Order { uint order[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Surfaces { ReflectingSurfaceRecord surfaces[]; };
layout(set = 0, binding = 4, scalar) writeonly buffer Vpls { Vpl vpls[]; };
layout(set = 0, binding = 5, scalar) writeonly buffer Lobes { VplLobes lobes[]; };
layout(set = 0, binding = 6, scalar) writeonly buffer Counts { uint counts[VPL_COUNT_WORDS]; };

/// make_rough_origin().
VplLobes make_lobes(ReflectingSurfaceRecord at) {
    const ShadingPoint surface = make_shading_point(Hit(at.t, at.instance, at.triangle, at.u, at.v), -at.wi_world);
    const Bsdf rough = bsdf_rough_part(make_bsdf(surface, at.outside_ior), push.connect_threshold);
    return VplLobes(surface.smooth_normal, at.wi_world, rough.flags, rough.diffuse, rough.alpha, rough.table_row,
                    rough.specular_f0, rough.specular_f90, rough.coat_f0, rough.coat_f90);
}

void main() {
    const uint light = flat_index(), total = min(state[REFLECTION_PHOTONS], push.most);
    if (light == 0) counts[VPL_COUNT] = total;
    if (light >= total) return;
    const ReflectedPhotonRecord photon = photons[order[light]];
    Vpl vpl;
    vpl.position = photon.position;
    vpl.correction = photon.correction;
    vpl.normal = photon.normal;
    vpl.smooth_normal = photon.smooth_normal;
    vpl.intensity = photon.power_w * INV_PI;
    vpl.surface = NO_VPL_SURFACE;
    vpl.scatterings = photon.scatterings_and_spread & 0xffu;
    vpl.choice = 0.0;
    if (!ONLY_LAMBERT && (photon.scatterings_and_spread >> SPREAD_SHIFT & 3u) == SPREAD_ROUGH) {
        vpl.surface = photon.surface;
        vpl.intensity = surfaces[photon.surface].arriving_power_w;
        lobes[photon.surface] = make_lobes(surfaces[photon.surface]);
    }
    vpls[light] = vpl;
}
