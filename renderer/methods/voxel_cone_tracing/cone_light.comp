#version 460
// Points lit by cones, a thread a point: five about the normal and one about the mirrored direction. [Crassin et al.
// 2011, section 5.1]
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define LOBE_ALBEDO_TABLE_BINDING 6
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/gbuffer_point.glsl"
#include "renderer/gbuffer/receiver.glsl"
#include "renderer/methods/voxel_cone_tracing/cone_march.glsl"
#include "renderer/transport/bsdf_lobe_albedos.glsl"

layout(local_size_x = CONE_GROUP) in;
layout(push_constant, scalar) uniform Push { ConeLightPush push; };
layout(set = 0, binding = 7, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 8, scalar) readonly buffer GeneralPoints { GBufferGeneral general_points[]; };
layout(set = 0, binding = 9, scalar) writeonly buffer Sums { vec3 sums[]; };

layout(constant_id = DRAWN_CONES_ID) const bool DRAWN_CONES = true;

uint random;  // of the point

vec3 radiance_along(GBufferPoint point, vec3 direction, float aperture) {
    const vec3 side = dot(point.geometric_normal, direction) < 0.0 ? -point.geometric_normal : point.geometric_normal;
    random = hash32(random);
    return cone_radiance(ConeStart(to_voxels(point.position), side), Cone(direction, aperture, push.march.step),
                         push.march.start, random);
}

float next_unit() {
    random = hash32(random);
    return to_unit_float(random);
}

/// One along the normal and four at 60 degrees from it, turned by chance; their weights, pi / 3 and pi / 6, are those by
/// which any radiance that is linear in the direction has its irradiance. Or each drawn by the cosine from as large a part
/// of the hemisphere.
vec3 irradiance_by_cones(GBufferPoint point, vec3 normal) {
    const Frame frame = make_frame(normal);
    const float turn = next_unit();
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 5; ++i) {
        const bool is_side = i > 0;
        float sin_sq = is_side ? 0.75 : 0.0, azimuth = float(i) + turn;
        if (DRAWN_CONES) {
            sin_sq = is_side ? mix(1.0 / 3.0, 1.0, next_unit()) : next_unit() / 3.0;
            azimuth = float(i) + (is_side ? next_unit() : 4.0 * turn);
        }
        const float radius = sqrt(sin_sq), phi = 0.5 * PI * azimuth;
        const vec3 direction = to_world(frame, vec3(radius * cos(phi), radius * sin(phi), sqrt(1.0 - sin_sq)));
        sum += (is_side ? PI / 6.0 : PI / 3.0) * radiance_along(point, direction, push.march.aperture);
    }
    return sum;
}

vec3 reflected(GBufferPoint point, GBufferGeneral general) {
    const Receiver receiver = make_receiver(general, push.march.glossy_threshold);
    const LobeAlbedos albedos = bsdf_lobe_albedos(receiver.rough, receiver.wo);
    const float aperture = push.march.gloss * albedos.alpha;
    vec3 sum = vec3(0.0);
    if (!is_black(albedos.diffuse))
        sum += INV_PI * albedos.diffuse * irradiance_by_cones(point, receiver.surface.shading.normal);
    if (!is_black(albedos.reflected)) {
        const vec3 mirrored = to_world(receiver.surface.shading, vec3(-receiver.wo.xy, receiver.wo.z));
        sum += albedos.reflected * radiance_along(point, mirrored, aperture);
    }
    if (!is_black(albedos.transmitted)) sum += albedos.transmitted * radiance_along(point, general.ray_direction, aperture);
    return sum;
}

void main() {
    const uint index = push.first_point + flat_index();
    if (index >= push.end_point) return;
    const GBufferPoint point = points[index];
    if (!is_lit(point)) return;
    random = hash32(point.pixel ^ push.march.key);
    sums[index] = is_general(point) ? reflected(point, general_points[index]) : irradiance_by_cones(point, point.normal);
}
