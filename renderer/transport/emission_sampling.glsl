// GLSL twin of transport/emission_sampling.cpp: light paths' first step, all kinds of lights behind one call. Which
// numbers decide what is as EmissionSampler (emission_sampling.h) says.
#ifndef PHOTOND_EMISSION_SAMPLING_GLSL
#define PHOTOND_EMISSION_SAMPLING_GLSL

#include "renderer/core/angles.glsl"
#include "renderer/core/geometry.glsl"
#include "renderer/transport/discrete_distribution.glsl"
#include "renderer/transport/emission.glsl"
#include "renderer/transport/emission_sampling_shared.h"
#include "renderer/transport/environment_sampling.glsl"
#include "renderer/transport/light_triangle.glsl"
#include "renderer/transport/punctual.glsl"
#include "renderer/transport/ray_start.glsl"
#include "renderer/transport/sampling.glsl"

DISCRETE_DISTRIBUTION(light_distribution, light_floats, light_words)

/// The start of a light path.
struct EmissionSample {
    Ray ray;        // moved off an emitting surface; unit direction
    vec3 power_w;   // flux [W] one path stands for if it were the only one: divide by the number of paths
    uint light;     // index as in emission_probability()
    uint source;    // light_source_of_*
    float range_m;  // point and spot lights: what their `range` leaves at distance d is range_window()
};

vec3 sample_sphere(vec2 u) {
    const float z = 1.0 - 2.0 * u.x;
    const float r = 2.0 * sqrt(max(0.0, u.x * (1.0 - u.x)));
    const vec2 azimuth = sin_cos(2.0 * PI * u.y);
    return vec3(r * azimuth.y, r * azimuth.x, z);
}

float emission_disc_m2() { return PI * sqr(light_constants.radius_m); }

Ray ray_from_outside(vec3 direction, vec2 u) {
    const float radius_m = light_constants.radius_m;
    const vec2 place = radius_m * sample_unit_disk(u);
    const Frame frame = make_frame(direction);
    const vec3 start = vec3(place, -EMISSION_START_IN_RADII * radius_m);
    return Ray(light_constants.centre + to_world(frame, start), direction, INFINITY);
}

// The three set ray, range and power, the last without the probability of the light's choice.

void sample_triangle_emission(uint index, vec2 u_position, vec2 u_direction, inout EmissionSample emission) {
    const EmitterRecord light = light_triangle(index);
    const bool two_sided = emitter_two_sided(light);
    bool front = true;
    if (two_sided) {
        front = u_direction.x < 0.5;
        u_direction.x = 2.0 * u_direction.x - (front ? 0.0 : 1.0);
    }
    const vec2 st = sample_triangle(u_position);
    vec3 radiance = light.radiance;
    if (emitter_varies(light))
        radiance = emitted_radiance(light.instance, light.triangle, st.x, st.y, front) *
                   surface_coverage(light.instance, light.triangle, st.x, st.y);
    emission.power_w = radiance * (light.area_m2 * PI * (two_sided ? 2.0 : 1.0));
    const vec3 normal = front ? light.normal : -light.normal;
    const vec3 point = light.corner + st.x * light.edge1 + st.y * light.edge2;
    const float clearance_m = patch_clearance(light.corner, light.edge1, light.edge2);
    emission.ray = Ray(clear_of_surface(point, normal, clearance_m),
                       to_world(make_frame(normal), sample_cosine_hemisphere(u_direction)), INFINITY);
    emission.range_m = INFINITY;
    emission.source = light_source_of_instance(light.instance);
}

void sample_punctual_emission(PunctualLightRecord light, vec2 u_position, vec2 u_direction,
                              inout EmissionSample emission) {
    emission.range_m = light.range_m;
    if (light.kind == PUNCTUAL_POINT) {
        emission.ray = Ray(light.position, sample_sphere(u_direction), INFINITY);
        emission.power_w = light.intensity * (4.0 * PI);
    } else if (light.kind == PUNCTUAL_SPOT) {
        emission.ray = Ray(light.position, to_world(make_frame(light.direction), spot_cone_sample(light, u_direction)),
                           INFINITY);
        emission.power_w = light.intensity * spot_cone_solid_angle(light);
    } else {
        emission.ray = ray_from_outside(light.direction, u_position);
        emission.power_w = light.intensity * emission_disc_m2();
        emission.range_m = INFINITY;
    }
}

bool sample_environment_emission(vec2 u_position, vec2 u_direction, inout EmissionSample emission) {
    vec3 wi;
    float pdf_sa;
    if (!environment_sample(environment_by_radiance(), u_direction, wi, pdf_sa)) return false;
    emission.ray = ray_from_outside(-wi, u_position);
    emission.power_w = environment_radiance(wi) * (emission_disc_m2() / pdf_sa);
    emission.range_m = INFINITY;
    return true;
}

/// Triangles, punctual lights, and the environment last.
uint emission_lights() {
    return light_constants.triangle_lights + light_constants.punctual_lights + (NEEDS_ENVIRONMENT ? 1u : 0u);
}

/// With which sample_emission() chooses a light: exact, a multiple of 2^-24.
float emission_probability(uint light) {
    if (light_constants.choice_guides == 0u) return 0.0;
    return light_distribution_probability(light_constants.choice_cdf, light);
}

/// Which of a light's two pairs of numbers decides what it sees most: directional lights are guided by the place on
/// their disc, all others by the direction.
bool emission_guided_by_position(uint light) {
    if (!NEEDS_PUNCTUAL_LIGHTS || light < light_constants.triangle_lights) return false;
    const uint punctual = light - light_constants.triangle_lights;
    return punctual < light_constants.punctual_lights && punctual_lights[punctual].kind == PUNCTUAL_DIRECTIONAL;
}

/// The same as sample_emission() for one light whose choice has that probability (already divided by in power_w), > 0.
/// False for a light that sample_emission() never chooses.
bool sample_emission_light(uint light, float probability, vec2 u_position, vec2 u_direction,
                           out EmissionSample emission) {
    emission = EmissionSample(Ray(vec3(0.0), vec3(0.0), INFINITY), vec3(0.0), light, 0u, INFINITY);
    if (!(emission_probability(light) > 0.0)) return false;
    const uint triangles = light_constants.triangle_lights, punctual = light_constants.punctual_lights;
    if (NEEDS_AREA_LIGHTS && light < triangles) {
        sample_triangle_emission(light, u_position, u_direction, emission);
    } else if (NEEDS_PUNCTUAL_LIGHTS && light < triangles + punctual) {
        const uint index = light - triangles;
        sample_punctual_emission(punctual_lights[index], u_position, u_direction, emission);
        emission.source = light_source_of_punctual(index);
    } else if (NEEDS_ENVIRONMENT) {
        if (!sample_environment_emission(u_position, u_direction, emission)) return false;
        emission.source = light_source_of_environment();
    }
    emission.power_w /= probability;
    return max_component(emission.power_w) > 0.0;
}

/// Draws a light as EmissionSampler does, then a point and a direction. All numbers uniform in [0, 1). False when the
/// sample carries nothing (a black texel, a masked one): a light path without light, which counts as emitted.
bool sample_emission(float u_light, vec2 u_position, vec2 u_direction, out EmissionSample emission) {
    const uint guides = light_constants.choice_guides;
    if (guides == 0u) {
        emission = EmissionSample(Ray(vec3(0.0), vec3(0.0), INFINITY), vec3(0.0), 0u, 0u, INFINITY);
        return false;
    }
    const uint light =
        light_distribution_sample(light_constants.choice_cdf, light_constants.choice_guide, guides, u_light);
    return sample_emission_light(light, emission_probability(light), u_position, u_direction, emission);
}

#endif
