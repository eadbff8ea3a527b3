// GLSL twin of transport/light_ends.h and .cpp: densities of a light's points and directions by both samplers, the one
// that lights a point from them and the one that starts light paths there.
#ifndef PHOTOND_LIGHT_ENDS_GLSL
#define PHOTOND_LIGHT_ENDS_GLSL

#include "renderer/transport/emission_sampling.glsl"
#include "renderer/transport/light_sampling.glsl"

/// Of one point or direction of a light; the measures of its densities are those of LightEnd (light_ends.h).
struct LightEnd {
    float direct;
    float emission;
    float cosine;  // between the direction and the light's normal; 1 where it has none
    bool delta;
    bool infinite;  // environment, directional lights
};
const LightEnd NO_LIGHT_END = LightEnd(0.0, 0.0, 1.0, false, false);

float emitted_by_cosine(uint emitter, float cosine) { return emitters[emitter].emission_per_m2 * cosine * INV_PI; }

float emission_pdf_punctual(uint punctual, vec3 direction) {
    const PunctualLightRecord light = punctual_lights[punctual];
    const float probability = emission_probability(light_constants.triangle_lights + punctual);
    if (light.kind == PUNCTUAL_POINT) return probability / (4.0 * PI);
    if (light.kind == PUNCTUAL_SPOT)
        return probability * spot_cone_falloff(light, dot(light.direction, direction)) / spot_cone_solid_angle(light);
    return probability / emission_disc_m2();
}

float emission_pdf_environment(vec3 wi) {
    return emission_probability(emission_lights() - 1u) * environment_pdf(environment_by_radiance(), wi) / emission_disc_m2();
}

/// A triangle that was met from p along `wi` (unit) at that distance, or that is to be drawn there.
LightEnd light_end_on_triangle(vec3 p, vec3 n, uint instance, uint triangle, vec3 wi, float distance) {
    LightEnd end = NO_LIGHT_END;
    const uint emitter = emitter_of(instance, triangle);
    if (emitter == NO_EMITTER) return end;
    end.cosine = abs(dot(emitters[emitter].normal, wi));
    end.direct = light_pdf_triangle(p, n, instance, triangle, wi, distance) * end.cosine / sqr(distance);
    end.emission = emitted_by_cosine(emitter, end.cosine);
    return end;
}

LightEnd light_end_of_environment(vec3 p, vec3 n, vec3 wi) {
    LightEnd end = NO_LIGHT_END;
    end.infinite = true;
    if (!NEEDS_ENVIRONMENT) return end;
    end.direct = light_pdf_environment(p, n, wi);
    end.emission = emission_pdf_environment(wi);
    return end;
}

/// Of what sample_light() drew. Its own density, over solid angle at p, goes to `pdf_direct_sa`.
LightEnd light_end_of_sample(LightSample light_sample, out float pdf_direct_sa) {
    LightEnd end = NO_LIGHT_END;
    end.delta = light_sample.delta;
    end.infinite = !(light_sample.distance < INFINITY);
    end.direct = pdf_direct_sa = light_sample.pdf_sa;
    if (light_sample.delta) {
        end.emission =
            emission_pdf_punctual(light_sample.source - light_source_of_punctual(0u), -light_sample.wi);
        if (!end.infinite) pdf_direct_sa *= sqr(light_sample.distance);
    } else if (end.infinite) {
        end.emission = emission_pdf_environment(light_sample.wi);
    } else {
        end.cosine = abs(dot(emitters[light_sample.emitter].normal, light_sample.wi));
        end.direct *= end.cosine / sqr(light_sample.distance);
        end.emission = emitted_by_cosine(light_sample.emitter, end.cosine);
    }
    return end;
}

/// Of what sample_emission() drew; `direct` is still to be asked for.
LightEnd light_end_of_emission(EmissionSample emission) {
    LightEnd end = NO_LIGHT_END;
    const uint triangles = light_constants.triangle_lights;
    if (emission.light < triangles) {
        const EmitterRecord light = light_triangle(emission.light);
        const uint emitter = emitter_of(light.instance, light.triangle);
        end.cosine = abs(dot(emitters[emitter].normal, emission.ray.direction));
        end.emission = emitted_by_cosine(emitter, end.cosine);
    } else if (emission.light < triangles + light_constants.punctual_lights) {
        const uint punctual = emission.light - triangles;
        end.delta = true;
        end.infinite = punctual_lights[punctual].kind == PUNCTUAL_DIRECTIONAL;
        end.emission = emission_pdf_punctual(punctual, emission.ray.direction);
    } else {
        end.infinite = true;
        end.emission = emission_pdf_environment(-emission.ray.direction);
    }
    return end;
}

/// ... at the path's first hit, which is p.
float light_direct_at_first_hit(EmissionSample emission, vec3 p, vec3 n, float distance) {
    const vec3 wi = -emission.ray.direction;
    const uint triangles = light_constants.triangle_lights;
    if (emission.light < triangles) {
        const EmitterRecord light = light_triangle(emission.light);
        return light_end_on_triangle(p, n, light.instance, light.triangle, wi, distance).direct;
    }
    if (emission.light < triangles + light_constants.punctual_lights)
        return light_probability_punctual(p, n, emission.light - triangles);
    return light_pdf_environment(p, n, wi);
}

#endif
