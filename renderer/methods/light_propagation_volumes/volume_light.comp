#version 460
// Points lit by the volumes, a thread a point. [Kaplanyan and Dachsbacher 2010, section 4.4]
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define PROPAGATION_CASCADES_BINDING 0
#define INJECTED_BINDING 1
#define VOLUME_BINDING 2
#define LOBE_ALBEDO_TABLE_BINDING 3
#define OPEN_FACES_BINDING 7
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/receiver.glsl"
#include "renderer/methods/light_propagation_volumes/volume_points.glsl"
#include "renderer/transport/bsdf_lobe_albedos.glsl"

layout(local_size_x = PROPAGATION_GROUP) in;
layout(push_constant, scalar) uniform Push { VolumeLightPush push; };
layout(set = 0, binding = 4, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 5, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 6, scalar) writeonly buffer Sums { vec3 sums[]; };

/// Narrow lobes see no more of the light's directions than wide ones.
vec3 reflected(VolumeLight light, GBufferGeneral general) {
    const Receiver receiver = make_receiver(general, push.glossy_threshold);
    const LobeAlbedos albedos = bsdf_lobe_albedos(receiver.rough, receiver.wo);
    const vec3 mirrored = to_world(receiver.surface.shading, vec3(-receiver.wo.xy, receiver.wo.z));
    return INV_PI * albedos.diffuse * irradiance(light, receiver.surface.shading.normal) +
           albedos.reflected * radiance_from(light, mirrored) +
           albedos.transmitted * radiance_from(light, general.ray_direction);
}

void main() {
    const uint index = push.first_point + flat_index();
    if (index >= push.end_point) return;
    const GBufferPoint point = points[index];
    if (!is_lit(point)) return;
    const VolumeLight light = volume_light(point);
    sums[index] = is_general(point) ? reflected(light, general_points[index]) : irradiance(light, point.normal);
}
