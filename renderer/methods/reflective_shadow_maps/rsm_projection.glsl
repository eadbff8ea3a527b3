// Where a point is in a light's map: the inverse of how EmissionSampler sends rays by their numbers.
#ifndef PHOTOND_RSM_PROJECTION_GLSL
#define PHOTOND_RSM_PROJECTION_GLSL

#include "renderer/transport/emission_sampling.glsl"

/// What one light's map is a map of.
struct RsmProjection {
    vec2 place;   // of the point in the light's unit square
    bool local;   // else every place is as near as any other
    bool around;  // the second coordinate is an azimuth: its ends meet
    float low;    // the light's part of the first coordinate for this point, two-sided triangles having one a side
    float high;
};

/// Inverse of sample_unit_disk(), for points of the unit disc.
vec2 unit_disk_inverse(vec2 at) {
    const float radius = length(at);
    if (!(radius > 0.0)) return vec2(0.5);
    const bool wide = abs(at.x) > abs(at.y);
    const float along = wide ? at.x : at.y, across = wide ? at.y : at.x;
    const float a = copysign(min(radius, 1.0), along), b = a * (4.0 * INV_PI) * atan(across / along);
    return 0.5 * (wide ? vec2(a, b) : vec2(b, a)) + 0.5;
}

float azimuth_number(vec2 direction) { return fract(atan(direction.y, direction.x) * (0.5 * INV_PI) + 1.0); }

/// Inverse of spot_cone_sample(); directions past the cone are on its rim.
float spot_cone_number(PunctualLightRecord light, float cosine) {
    const float below_one = 1.0 - cosine;
    if (below_one <= light.plateau) return below_one / (light.plateau + light.ramp);
    const float rest = 1.0 - clamp((below_one - light.plateau) / light.reach, 0.0, 1.0);
    return (light.plateau + light.ramp * (1.0 - rest * rest * rest)) / (light.plateau + light.ramp);
}

RsmProjection project_to_light(uint light, vec3 point) {
    RsmProjection to = RsmProjection(vec2(0.5), true, false, 0.0, 1.0);
    const uint triangles = light_constants.triangle_lights;
    if (NEEDS_AREA_LIGHTS && light < triangles) {
        const EmitterRecord triangle = light_triangle(light);
        const vec3 middle = triangle.corner + (triangle.edge1 + triangle.edge2) * (1.0 / 3);
        const vec3 direction = normalize(point - middle);
        const bool back = emitter_two_sided(triangle) && dot(direction, triangle.normal) < 0.0;
        const vec3 local = to_local(make_frame(back ? -triangle.normal : triangle.normal), direction);
        // Below its horizon: on the rim.
        to.place = unit_disk_inverse(local.z > 0.0 ? local.xy : normalize(local.xy));
        if (emitter_two_sided(triangle)) {
            to.low = back ? 0.5 : 0.0;
            to.high = to.low + 0.5;
            to.place.x = to.low + 0.5 * to.place.x;
        }
    } else if (NEEDS_PUNCTUAL_LIGHTS && light < triangles + light_constants.punctual_lights) {
        const PunctualLightRecord punctual = punctual_lights[light - triangles];
        if (punctual.kind == PUNCTUAL_DIRECTIONAL) {
            const vec3 local = to_local(make_frame(punctual.direction), point - light_constants.centre);
            to.place = unit_disk_inverse(local.xy / light_constants.radius_m);
        } else {
            vec3 direction = normalize(point - punctual.position);
            to.around = true;
            if (punctual.kind == PUNCTUAL_SPOT) {
                direction = to_local(make_frame(punctual.direction), direction);
                to.place = vec2(spot_cone_number(punctual, direction.z), azimuth_number(direction.xy));
            } else {
                to.place = vec2(0.5 - 0.5 * direction.z, azimuth_number(direction.xy));
            }
        }
    } else {
        to.local = false;
    }
    return to;
}

#endif
