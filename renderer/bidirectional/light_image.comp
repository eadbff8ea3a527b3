#version 460
// What the camera sees of light paths, a thread a pixel: its splats, sorted by the pixel they lie in, are added in their
// order. CPU twin: LightPaths::add_splats() and add_joined().
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#define IMAGE_BINDING 0
#define EYE_BINDING 1
#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/bidirectional/joined_light.glsl"

layout(local_size_x = LIGHT_PATHS_GROUP) in;
layout(push_constant, scalar) uniform Push { LightImagePush push; };
layout(set = 0, binding = 2, scalar) readonly buffer Starts { uint starts[]; };  // of the grid of splats
layout(set = 0, binding = 3, scalar) readonly buffer Order { uint order[]; };
layout(set = 0, binding = 4, std430) readonly buffer SplatPlaces { uvec4 splat_places[]; };  // film [pixels]
layout(set = 0, binding = 5, scalar) readonly buffer Splats { LightSplatRecord splats[]; };

const float kBinWidth = 2.0 * FILTER_RADIUS / float(FILTER_BINS);

/// PixelFilterSampler::drawn_density().
float drawn_density(float x) {
    const float bin = (x + FILTER_RADIUS) / kBinWidth;
    if (!(bin >= 0.0 && bin < float(FILTER_BINS))) return 0.0;
    const uint i = uint(bin);
    return (eye.filter_cdf[i + 1] - eye.filter_cdf[i]) / kBinWidth;
}

void main() {
    const uint pixel = flat_index();
    if (pixel >= eye.width * eye.height) return;
    const ivec2 at = ivec2(pixel % eye.width, pixel / eye.width);
    const bool smooth_filter = eye.smooth_filter != 0;
    const int reach = smooth_filter ? int(push.margin) : 0;
    JoinedLight light = no_joined_light();
    for (int y = at.y - reach; y <= at.y + reach; ++y) {
        // The cells of a row hold one run of splats.
        const uint first = uint(y + int(push.margin)) * push.columns + uint(at.x - reach + int(push.margin));
        const uint end = starts[first + uint(2 * reach + 1)];
        for (uint i = starts[first]; i < end; ++i) {
            const uint place = order[i];
            float density = 1.0;
            if (smooth_filter) {
                const vec2 from_centre = uintBitsToFloat(splat_places[place].xy) - vec2(at) - 0.5;
                density = drawn_density(from_centre.x) * drawn_density(from_centre.y);
            }
            if (!(density > 0.0)) continue;
            const LightSplatRecord splat = splats[place];
            add_joined(light, splat.scatterings & ~LIGHT_SPLAT_CAUSTIC, (splat.scatterings & LIGHT_SPLAT_CAUSTIC) != 0,
                       JOIN_LIGHT_IMAGE, density * splat.radiance);
        }
    }
    store_joined_light(pixel, light);
    if (layer_kept(LAYER_TECHNIQUES)) add_rgb(LAYER_TECHNIQUES, pixel, push.techniques);
}
