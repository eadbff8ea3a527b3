// Soft shadows by gathering in the image [Robison and Shirley 2009; Yao 2011, section 3.4]: each pixel knows whether the
// middle of its light is hidden, and how far off what hides it is. The mean of such distances about a pixel, d, tells how
// wide its penumbra is: L d / (D - d), L the radius of the light and D the distance to it. The share of pixels of that
// disc that are lit is what is seen of the light.
//
// Define UNSHADOWED_LIGHTS (an array of UnshadowedLight, pixel by pixel) and LAMP_SHAPES (of LampShape) before.
//
// [Robison and Shirley 2009] Image Space Gathering. HPG.
#ifndef PHOTOND_SOFT_SHADOWS_GLSL
#define PHOTOND_SOFT_SHADOWS_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/core/rng.glsl"
#include "renderer/eye/eye_shared.h"
#include "renderer/gbuffer/centre_shadows_shared.h"
#include "renderer/gbuffer/lamps.glsl"
#include "renderer/methods/image_space_photon_mapping/soft_shadows_shared.h"
#include "renderer/transport/sampling.glsl"

layout(constant_id = SOFT_SHADOW_ID) const uint SOFT_SHADOW = SOFT_SHADOW_RAYS;

/// What is seen of a pixel's light, and how that was found.
struct SoftShadow {
    float seen;         // share of it
    float occluder_m;   // mean distance of what hides it; 0: nothing does
    float blur_pixels;  // radius
};

/// Sums over the pixels of a disc about a pixel that have the same light, each weighed by exp(-t^2 / radius^2), t its
/// distance in the world.
struct DiscOfPixels {
    float weight;
    float lit;         // of those whose light is not hidden
    float occluder_m;  // of the others', times their weights
};

DiscOfPixels gather_pixels(EyeConstants eye, uint pixel, UnshadowedLight here, float radius_m, float pixels_a_metre,
                           uint samples, uint turn) {
    DiscOfPixels found = DiscOfPixels(0.0, 0.0, 0.0);
    const ivec2 middle = ivec2(pixel % eye.width, pixel / eye.width), size = ivec2(eye.width, eye.height);
    const float radius = radius_m * pixels_a_metre;
    const vec2 shift = vec2(hash32(pixel ^ turn) & 0xffffu, hash32(pixel ^ turn) >> 16) / 65536.0;
    for (uint i = 0; i < samples * samples; ++i) {
        const vec2 u = (vec2(i % samples, i / samples) + shift) / float(samples);
        const ivec2 at = middle + ivec2(round(radius * sample_unit_disk(u)));
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, size))) continue;
        const UnshadowedLight there = UNSHADOWED_LIGHTS[uint(at.y) * eye.width + uint(at.x)];
        if (there.lamp != here.lamp) continue;
        const vec3 apart = there.position - here.position;
        const float weight = exp(-dot(apart, apart) / sqr(radius_m));
        found.weight += weight;
        if (there.occluder_m > 0.0) found.occluder_m += weight * there.occluder_m;
        else found.lit += weight;
    }
    return found;
}

SoftShadow soft_shadow(EyeConstants eye, uint pixel, UnshadowedLight here, ShadowSamples samples, uint turn) {
    const bool hidden = here.occluder_m > 0.0;
    const SoftShadow hard = SoftShadow(hidden ? 0.0 : 1.0, here.occluder_m, 0.0);
    if (SOFT_SHADOW == SOFT_SHADOW_NONE) return hard;
    const LampShape shape = LAMP_SHAPES[here.lamp];
    const vec3 to_lamp = shape.centre - here.position;
    const float distance_m = length(to_lamp), lamp_m = lamp_radius_m(shape, to_lamp / distance_m);
    if (!(lamp_m > 0.0)) return hard;
    const float depth_m = dot(here.position - eye.camera.position, eye.camera.forward);
    const float pixels_a_metre =
        1.0 / (length(eye.camera.pixel_x) * (eye.camera.orthographic != 0 ? 1.0 : max(depth_m, 1e-30)));
    float occluder_m = 0.5 * distance_m;
    if (SOFT_SHADOW == SOFT_SHADOW_GATHER) {
        const DiscOfPixels about = gather_pixels(eye, pixel, here, lamp_m, pixels_a_metre, samples.search, turn);
        const float hidden_weight = about.weight - about.lit;
        if (hidden_weight > 1e-3 * about.weight) occluder_m = about.occluder_m / hidden_weight;
        else if (hidden) occluder_m = here.occluder_m;
        else return hard;
    }
    // Not wider than it is far: of what hides at the light itself nothing is known.
    const float blur_m = min(lamp_m * occluder_m / max(distance_m - occluder_m, 1e-30), distance_m);
    const SoftShadow nothing_about = SoftShadow(hard.seen, occluder_m, blur_m * pixels_a_metre);
    const DiscOfPixels about =
        gather_pixels(eye, pixel, here, blur_m, pixels_a_metre, samples.blur, turn + 0x9e3779b9u);
    if (!(about.weight > 0.0)) return nothing_about;
    return SoftShadow(about.lit / about.weight, occluder_m, nothing_about.blur_pixels);
}

#endif
