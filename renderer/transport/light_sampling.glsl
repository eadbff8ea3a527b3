// GLSL twin of transport/light_sampling.cpp: direct light, all kinds of lights behind one call. Arguments, densities
// and what false means are as LightSampler (light_sampling.h) says.
#ifndef PHOTOND_LIGHT_SAMPLING_GLSL
#define PHOTOND_LIGHT_SAMPLING_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/transport/emission.glsl"
#include "renderer/transport/environment_sampling.glsl"
#include "renderer/transport/light_sampling_shared.h"
#include "renderer/transport/light_tree.glsl"
#include "renderer/transport/light_triangle.glsl"
#include "renderer/transport/punctual.glsl"
#include "renderer/transport/ray_start.glsl"
#include "renderer/transport/sampling.glsl"
#include "renderer/transport/solid_angle_sampling.glsl"

/// Of the environment, as EnvironmentDensity::Compensated asks.
layout(constant_id = LIGHT_SAMPLES_COMPENSATED_ID) const bool LIGHT_SAMPLES_COMPENSATED = false;

/// One direction towards a light, before it is known whether anything is in between.
struct LightSample {
    vec3 wi;                 // unit, from the lit point to the light
    float distance;          // [m]; infinite for directional lights and the environment
    vec3 target;             // end of the shadow ray where the distance is finite, just before the light's surface
    vec3 radiance_over_pdf;  // [W m^-2]: estimate of L / pdf_sa; delta lights: perpendicular irradiance / probability
    float pdf_sa;            // [1/sr], choice of light included; delta lights: probability of the choice alone
    bool delta;              // no other technique finds this light: its MIS weight is 1
    uint source;             // what casts one shadow: light_source_of_*
    uint emitter;            // NO_EMITTER where it is none: directional lights and the environment
};

/// The ray that must not be occluded. `origin`: the lit point, moved off its surface (offset_ray_origin).
Ray shadow_ray(LightSample light_sample, vec3 origin) {
    const bool finite = light_sample.distance < INFINITY;
    return Ray(origin, finite ? light_sample.target - origin : light_sample.wi, finite ? 1.0 : INFINITY);
}

/// Intensity of a point or spot towards `wo` (unit, from the light) over the squared distance: perpendicular irradiance
/// [W m^-2]. Cone and window as KHR_lights_punctual recommends.
vec3 punctual_irradiance(PunctualLightRecord light, vec3 wo, float distance) {
    float factor = 1.0 / sqr(distance);
    factor *= range_window(distance, light.range_m);
    if (light.kind == PUNCTUAL_SPOT) factor *= spot_cone_falloff(light, dot(light.direction, wo));
    return light.intensity * factor;
}

/// Solid angles of the one or two triangles of an emitter seen from p; {0, 0} where it is drawn by area.
struct SeenFrom {
    vec3 a, b, c, d;  // unit directions to corner, corner + edge1, corner + edge2, and the parallelogram's fourth
    float omega1;
    float omega2;
};
float seen_omega(SeenFrom seen) { return seen.omega1 + seen.omega2; }

SeenFrom see(EmitterRecord e, vec3 p) {
    const bool two = emitter_shape(e) == EMITTER_PARALLELOGRAM;
    const float centre = two ? 0.5 : 1.0 / 3;
    const vec3 corner = e.corner - p;
    const vec3 to_centre = corner + centre * (e.edge1 + e.edge2);
    SeenFrom seen = SeenFrom(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), 0.0, 0.0);
    // The solid angle is at most about area / distance^2 for a small emitter; twice the threshold covers the rest.
    if (2.0 * e.area_m2 < LIGHT_SPHERICAL_FROM * dot(to_centre, to_centre)) return seen;
    seen.a = normalize(corner);
    seen.b = normalize(corner + e.edge1);
    seen.c = normalize(corner + e.edge2);
    seen.omega1 = triangle_solid_angle(seen.a, seen.b, seen.c);
    if (two) {
        seen.d = normalize(corner + e.edge1 + e.edge2);
        seen.omega2 = triangle_solid_angle(seen.d, seen.c, seen.b);
    }
    const float omega = seen_omega(seen);
    const float kLeast = 1e-3;  // of each half, for sample_spherical_triangle()
    const bool fits = omega >= LIGHT_SPHERICAL_FROM && seen.omega1 > kLeast && seen.omega1 < LIGHT_SPHERICAL_TO &&
                      (!two || (seen.omega2 > kLeast && seen.omega2 < LIGHT_SPHERICAL_TO));
    if (!fits) seen.omega1 = seen.omega2 = 0.0;
    return seen;
}

/// Weights of corner + s edge1 + t edge2 where the line from p along w meets the emitter's plane.
vec2 meet_plane(EmitterRecord e, vec3 p, vec3 w) {
    const vec3 across = cross(w, e.edge2);
    const float inverse = 1.0 / dot(across, e.edge1);
    const vec3 s = p - e.corner;
    return clamp(vec2(dot(s, across), dot(w, cross(s, e.edge1))) * inverse, vec2(0.0), vec2(1.0));
}

uint emitter_of(uint instance, uint triangle) {
    if (!NEEDS_AREA_LIGHTS) return NO_EMITTER;
    const uint first = light_words[light_constants.first_of_instance + instance];
    if (first == NO_EMITTER) return NO_EMITTER;
    return light_words[light_constants.emitter_of_triangle + first + triangle];
}

uint directional_light(uint i) { return light_words[light_constants.directional + i]; }

/// What a group of lights could bring to p, if nothing were in between: irradiance, mean over channels.
float directional_estimate(PunctualLightRecord sun, vec3 n) {
    const float cosine = n == vec3(0.0) ? 1.0 : max(0.0, -dot(n, sun.direction));
    return mean(sun.intensity) * cosine;
}
float environment_estimate() { return PI * environment_mean_radiance(); }
EnvironmentDensity light_samples_density() {
    if (LIGHT_SAMPLES_COMPENSATED) return environment_compensated();
    return environment_by_radiance();
}

/// Sum of the groups' estimates at p and the number of groups that can reach it.
struct LightGroups {
    float tree;
    float sum;
    float reaching;
};
/// Half by estimate, half evenly: the estimate knows nothing of what lies in between.
float light_groups_probability(LightGroups g, float estimate) {
    return estimate > 0.0 ? 0.5 * estimate / g.sum + 0.5 / g.reaching : 0.0;
}
void light_groups_add(inout LightGroups g, float estimate) {
    g.sum += estimate;
    g.reaching += estimate > 0.0 ? 1.0 : 0.0;
}
LightGroups light_groups(vec3 p, vec3 n) {
    LightGroups g = LightGroups(light_tree_irradiance_estimate(p, n), 0.0, 0.0);
    light_groups_add(g, g.tree);
    if (NEEDS_PUNCTUAL_LIGHTS)
        for (uint i = 0u; i < light_constants.directional_lights; ++i)
            light_groups_add(g, directional_estimate(punctual_lights[directional_light(i)], n));
    light_groups_add(g, environment_estimate());
    return g;
}

/// A point or a spot that was chosen with that probability.
bool sample_punctual_emitter(EmitterRecord e, vec3 p, float probability, out LightSample light_sample) {
    const vec3 to_light = e.corner - p;
    const float distance = length(to_light);
    if (!(distance > 0.0)) return false;
    light_sample.wi = to_light / distance;
    light_sample.distance = distance;
    light_sample.target = e.corner;
    light_sample.radiance_over_pdf =
        punctual_irradiance(punctual_lights[e.instance], -light_sample.wi, distance) / probability;
    light_sample.pdf_sa = probability;
    light_sample.delta = true;
    light_sample.source = light_source_of_punctual(e.instance);
    return max_component(light_sample.radiance_over_pdf) > 0.0;
}

/// A triangle or parallelogram that was chosen with that probability.
bool sample_area_emitter(EmitterRecord e, vec3 p, vec2 u, float probability, out LightSample light_sample) {
    light_sample.source = light_source_of_instance(e.instance);
    const float height = dot(e.normal, p - e.corner);  // of p above the emitter's plane
    if (emitter_two_sided(e) ? height == 0.0 : !(height > 0.0)) return false;

    const SeenFrom seen = see(e, p);
    const bool spherical = seen.omega1 > 0.0;
    vec2 st;
    if (spherical) {
        const float share = seen.omega1 / seen_omega(seen);
        const bool first = u.x < share;
        const vec2 v = vec2(min(first ? u.x / share : (u.x - share) / (1.0 - share), BELOW_ONE), u.y);
        // One call for both halves: lanes that draw from either stay together.
        const vec3 w =
            sample_spherical_triangle(first ? seen.a : seen.d, first ? seen.b : seen.c, first ? seen.c : seen.b, v);
        st = meet_plane(e, p, w);
    } else {
        st = emitter_shape(e) == EMITTER_TRIANGLE ? sample_triangle(u) : u;
    }
    const vec3 point = e.corner + st.x * e.edge1 + st.y * e.edge2;
    const vec3 to_light = point - p;
    const float distance_sq = dot(to_light, to_light);
    if (!(distance_sq > 0.0)) return false;
    light_sample.distance = sqrt(distance_sq);
    const float inverse = 1.0 / light_sample.distance;
    light_sample.wi = inverse * to_light;
    // Found from p, whose own coordinates round the ray too.
    const float clearance_m = max(patch_clearance(e.corner, e.edge1, e.edge2), CLEARANCE * max_component(abs(p)));
    light_sample.target = clear_of_surface(point, height > 0.0 ? e.normal : -e.normal, clearance_m);
    light_sample.delta = false;
    const float cosine = abs(height) * inverse;  // exact at grazing angles, where a product of units is not
    const float solid_angle = spherical ? seen_omega(seen) : e.area_m2 * cosine * inverse * inverse;
    light_sample.pdf_sa = probability / solid_angle;
    vec3 radiance = e.radiance;
    if (emitter_varies(e)) {
        radiance = emitted_radiance(e.instance, e.triangle, st.x, st.y, height > 0.0) *
                   surface_coverage(e.instance, e.triangle, st.x, st.y);
        if (!(max_component(radiance) > 0.0)) return false;
    }
    light_sample.radiance_over_pdf = (solid_angle / probability) * radiance;
    return light_sample.pdf_sa < INFINITY;
}

/// Fills everything for a light that was chosen with that probability.
bool sample_emitter(uint emitter, vec3 p, vec2 u, float probability, out LightSample light_sample) {
    const EmitterRecord e = emitters[emitter];
    const bool punctual = NEEDS_PUNCTUAL_LIGHTS && (!NEEDS_AREA_LIGHTS || emitter_shape(e) >= EMITTER_POINT);
    bool carries;
    if (punctual)
        carries = sample_punctual_emitter(e, p, probability, light_sample);
    else
        carries = sample_area_emitter(e, p, u, probability, light_sample);
    light_sample.emitter = emitter;
    return carries;
}

bool sample_light_from_tree(vec3 p, vec3 n, float u_select, vec2 u, float group_probability,
                            out LightSample light_sample) {
    LightTreeChoice choice;
    return light_tree_sample(p, n, u_select, choice) &&
           sample_emitter(choice.light, p, u, choice.probability * group_probability, light_sample);
}

/// Whether u_select falls to what comes next in the cumulative probabilities, and what is then left of it.
bool light_group_chosen(float u_select, float probability, inout float below, out float rest) {
    if (u_select >= below + probability) {
        below += probability;
        return false;
    }
    rest = clamp((u_select - below) / probability, 0.0, BELOW_ONE);
    return true;
}

bool sample_light_groups(vec3 p, vec3 n, float u_select, vec2 u, out LightSample light_sample) {
    const LightGroups g = light_groups(p, n);
    if (!(g.sum > 0.0)) return false;
    // Walks the cumulative probabilities: tree, directional lights, environment.
    float below = 0.0, rest;
    const float tree_probability = light_groups_probability(g, g.tree);
    if (light_group_chosen(u_select, tree_probability, below, rest))
        return sample_light_from_tree(p, n, rest, u, tree_probability, light_sample);
    if (NEEDS_PUNCTUAL_LIGHTS) {
        // Found in the loop, filled in after it: lanes that find theirs in different rounds do so together. (A loop
        // whose body goes on by `continue` and ends in `return` is compiled wrongly by lavapipe of Mesa 22.3: it
        // never returns.)
        bool found = false;
        uint light;
        float probability;
        for (uint i = 0u; i < light_constants.directional_lights && !found; ++i) {
            light = directional_light(i);
            probability = light_groups_probability(g, directional_estimate(punctual_lights[light], n));
            found = light_group_chosen(u_select, probability, below, rest);
        }
        if (found) {
            light_sample.wi = -punctual_lights[light].direction;
            light_sample.distance = INFINITY;
            light_sample.radiance_over_pdf = punctual_lights[light].intensity / probability;
            light_sample.pdf_sa = probability;
            light_sample.delta = true;
            light_sample.source = light_source_of_punctual(light);
            light_sample.emitter = NO_EMITTER;
            return true;
        }
    }
    if (!NEEDS_ENVIRONMENT) return false;
    const float probability = light_groups_probability(g, environment_estimate());
    if (!(probability > 0.0) || !environment_sample(light_samples_density(), u, light_sample.wi, light_sample.pdf_sa))
        return false;
    light_sample.pdf_sa *= probability;
    light_sample.distance = INFINITY;
    light_sample.radiance_over_pdf = environment_radiance(light_sample.wi) / light_sample.pdf_sa;
    light_sample.delta = false;
    light_sample.source = light_source_of_environment();
    light_sample.emitter = NO_EMITTER;
    return max_component(light_sample.radiance_over_pdf) > 0.0;
}

/// Draws one light and a direction to it. `u_select` and `u` uniform in [0,1). False when the sample carries nothing:
/// the estimate is then zero, and nothing else of it means anything.
bool sample_light(vec3 p, vec3 n, float u_select, vec2 u, out LightSample light_sample) {
    light_sample = LightSample(vec3(0.0), INFINITY, vec3(0.0), vec3(0.0), 0.0, false, 0u, NO_EMITTER);
    if (NEEDS_LIGHT_GROUPS) return sample_light_groups(p, n, u_select, u, light_sample);
    return sample_light_from_tree(p, n, u_select, u, 1.0, light_sample);
}

/// With which sample_light() chooses an emitter.
float light_emitter_probability(vec3 p, vec3 n, uint emitter) {
    const float probability = light_tree_probability(p, n, emitter);
    if (!NEEDS_LIGHT_GROUPS || !(probability > 0.0)) return probability;
    const LightGroups g = light_groups(p, n);
    return probability * light_groups_probability(g, g.tree);
}

/// With which it chooses that punctual light.
float light_probability_punctual(vec3 p, vec3 n, uint light) {
    const uint emitter = light_words[light_constants.emitter_of_punctual + light];
    if (emitter != NO_EMITTER) return light_emitter_probability(p, n, emitter);
    return light_groups_probability(light_groups(p, n), directional_estimate(punctual_lights[light], n));
}

/// Density [1/sr] with which sample_light() draws the direction `wi` (unit) that meets this triangle at `distance`; 0
/// when the triangle is no light.
float light_pdf_triangle(vec3 p, vec3 n, uint instance, uint triangle, vec3 wi, float distance) {
    const uint emitter = emitter_of(instance, triangle);
    if (emitter == NO_EMITTER) return 0.0;
    const EmitterRecord e = emitters[emitter];
    const float probability = light_emitter_probability(p, n, emitter);
    const float cosine = abs(dot(e.normal, wi));
    if (!(probability > 0.0) || !(cosine > 0.0)) return 0.0;
    const SeenFrom seen = see(e, p);
    if (seen.omega1 > 0.0) return probability / seen_omega(seen);
    return probability * sqr(distance) / (e.area_m2 * cosine);
}

/// Density [1/sr] with which sample_light() draws `wi` (unit) from the environment; 0 without one.
float light_pdf_environment(vec3 p, vec3 n, vec3 wi) {
    if (!NEEDS_ENVIRONMENT) return 0.0;
    const float probability = light_groups_probability(light_groups(p, n), environment_estimate());
    return probability > 0.0 ? probability * environment_pdf(light_samples_density(), wi) : 0.0;
}

#endif
