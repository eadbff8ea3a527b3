#version 460
// gbuffer_walk.comp with the first surface's light kept apart from its shadow, by the middles of lights
// (centre_shadows_gpu.h).
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/gbuffer/centre_shadows_shared.h"
#include "renderer/gbuffer/lamps_shared.h"
layout(set = 0, binding = 6, scalar) readonly buffer LampShapes { LampShape lamp_shapes[]; };
layout(set = 0, binding = 7, scalar) readonly buffer LampWords { uint lamp_words[]; };
layout(set = 0, binding = 8, scalar) writeonly buffer UnshadowedLights { UnshadowedLight unshadowed_lights[]; };

#define WALK_KEEPS_LIGHT_APART
#include "renderer/gbuffer/gbuffer_walk.glsl"

float walk_light_number() { return sample_2d(pixel_key(0), sample_set(0, SET_LIGHT_CHOICE_AND_ROULETTE)).x; }

uint lamp_of(LightSample light_sample) {
    if (light_sample.emitter == NO_EMITTER)  // a directional light
        return lamp_words[LAMP_FIRST_PUNCTUAL] + light_sample.source - light_source_of_punctual(0u);
    return lamp_words[LAMP_OF_EMITTERS + light_sample.emitter];
}

bool walk_keeps_apart(EyePath path, Ray ray, LightSample light_sample, vec3 radiance) {
    if (light_sample.source == light_source_of_environment()) return false;
    const uint lamp = lamp_of(light_sample);
    const bool has_extent = lamp < lamp_words[LAMP_FIRST_PUNCTUAL];
    const Ray to_centre = has_extent ? Ray(ray.origin, lamp_shapes[lamp].centre - ray.origin, 1.0) : ray;
    const Hit hit = closest_hit(to_centre);
    bool hidden = hit_valid(hit);
    if (hidden && has_extent) {  // a lamp does not hide its own middle
        const uint emitter = emitter_of(hit.instance, hit.triangle);
        hidden = emitter == NO_EMITTER || lamp_words[LAMP_OF_EMITTERS + emitter] != lamp;
    }
    const float occluder_m = hidden ? max(hit.t * length(to_centre.direction), LEAST_OCCLUDER_M) : 0.0;
    unshadowed_lights[path.pixel] = UnshadowedLight(path.position, occluder_m, radiance, lamp);
    return true;
}
