// Which of the lights that a point looks at it asks for V, by what they would bring unshadowed alone: V is asked for what
// it may depend on, so the mean stays. Declare `constants` (VplLightingConstants) before.
#ifndef PHOTOND_VPL_ROULETTE_GLSL
#define PHOTOND_VPL_ROULETTE_GLSL

#include "renderer/many_lights/vpl_lighting.glsl"

struct VplRoulette {
    float bright;  // lights that bring as much are always asked
    float least_chance;
    uint key;
};

/// `total`: what all bring together; `lit`: how many bring anything. Both 0: all are asked.
VplRoulette vpl_roulette(GBufferPoint point, float total, float lit) {
    return VplRoulette(lit > 0.0 ? constants.roulette * total / lit : 0.0,
                       is_general(point) ? VPL_LEAST_GENERAL_CHANCE : 0.0,
                       point_key(point, constants.seed, constants.pass));
}

/// Of a light that brings `size`: the chance with which it is asked, and 0 where it is not.
float asked_chance(VplRoulette roulette, float size, uint light) {
    if (!(size > 0.0)) return 0.0;
    if (!(size < roulette.bright)) return 1.0;
    const float chance = max(size / roulette.bright, roulette.least_chance);
    return to_unit_float(hash32(roulette.key + 0x9e3779b9u * light)) < chance ? chance : 0.0;
}

#endif
