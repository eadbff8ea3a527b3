// GLSL twin of scene/texture.h and texture.cpp: filtered lookups in the scene's one array of texels.
#ifndef PHOTOND_TEXTURE_GLSL
#define PHOTOND_TEXTURE_GLSL

#include "renderer/backends/gpu/scene.glsl"

bool texture_used(TextureRefRecord reference) { return reference.texture != NO_TEXTURE; }

/// The two texels along one axis and the weight of the second.
struct Taps {
    uint first;
    uint second;
    float weight;
};

/// A coordinate folded into [0, 1] by the wrap mode. NaN and infinity, of which no texel is right, become 0.
float fold(float t, uint wrap) {
    if (wrap == WRAP_REPEAT) {
        t -= floor(t);
    } else if (wrap == WRAP_MIRRORED_REPEAT) {
        t -= 2.0 * floor(0.5 * t);
        if (t > 1.0) t = 2.0 - t;
    } else if (t > 1.0) {
        t = 1.0;
    }
    return t >= 0.0 ? t : 0.0;
}

uint nearest_texel(float t, uint wrap, uint size) { return min(uint(fold(t, wrap) * float(size)), size - 1u); }

Taps bilinear_taps(float t, uint wrap, uint size) {
    const float x = fold(t, wrap) * float(size) - 0.5;  // texel centres lie at whole numbers
    const float floor_x = floor(x);
    const int last = int(size) - 1;
    int first = int(floor_x);
    int second = first + 1;
    if (wrap == WRAP_REPEAT) {
        if (first < 0) first = last;
        if (second > last) second = 0;
    } else {  // beyond a mirrored or clamped edge lies the edge's own texel
        if (first < 0) first = 0;
        if (second > last) second = last;
    }
    if (first > last) first = last;  // float rounding at t = 1 in very wide images
    return Taps(uint(first), uint(second), x - floor_x);
}

/// `srgb`: the first three channels are decoded by the sRGB curve.
vec4 decoded(uint texel, bool srgb) {
    const float kScale = 1.0 / 255.0;
    const uvec4 codes = uvec4(texel, texel >> 8, texel >> 16, texel >> 24) & 0xffu;
    if (srgb)
        return vec4(scene_constants.srgb_to_linear[codes.x], scene_constants.srgb_to_linear[codes.y],
                    scene_constants.srgb_to_linear[codes.z], kScale * float(codes.w));
    return kScale * vec4(codes);
}

/// Filtered lookup in the texture of that number. `srgb`: the first three channels are decoded by the sRGB curve before
/// filtering. All in [0, 1].
vec4 sample_texture(int texture_index, vec2 uv, bool srgb) {
    const TextureRecord image = scene_textures[texture_index];
    if (image.nearest != 0u)
        return decoded(scene_texels[image.first_texel + nearest_texel(uv.y, image.wrap_t, image.height) * image.width +
                                    nearest_texel(uv.x, image.wrap_s, image.width)],
                       srgb);
    const Taps s = bilinear_taps(uv.x, image.wrap_s, image.width);
    const Taps t = bilinear_taps(uv.y, image.wrap_t, image.height);
    const uint row0 = image.first_texel + t.first * image.width;
    const uint row1 = image.first_texel + t.second * image.width;
    // All four are asked for before the first is needed.
    const uint texel00 = scene_texels[row0 + s.first], texel01 = scene_texels[row0 + s.second];
    const uint texel10 = scene_texels[row1 + s.first], texel11 = scene_texels[row1 + s.second];
    const vec4 top = (1.0 - s.weight) * decoded(texel00, srgb) + s.weight * decoded(texel01, srgb);
    const vec4 bottom = (1.0 - s.weight) * decoded(texel10, srgb) + s.weight * decoded(texel11, srgb);
    return (1.0 - t.weight) * top + t.weight * bottom;
}

#endif
