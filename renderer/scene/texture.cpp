#include "renderer/scene/texture.h"

#include <array>
#include <cmath>

#include "renderer/core/srgb.h"

namespace photond {

namespace {

using Table = std::array<float, 256>;

/// sRGB decoding of 8-bit codes; computed once at start-up, so that lookups need no guard.
const Table kSrgbToLinear = [] {
    Table table;
    for (size_t code = 0; code < table.size(); ++code)
        table[code] = static_cast<float>(srgb_decode(static_cast<double>(code) / 255.0));
    return table;
}();

/// The two texels along one axis and the weight of the second.
struct Taps {
    uint32_t first;
    uint32_t second;
    float weight;
};

/// A coordinate folded into [0, 1] by the wrap mode. NaN and infinity, of which no texel is right, become 0.
float fold(float t, Wrap wrap) {
    if (wrap == Wrap::Repeat) {
        t -= std::floor(t);
    } else if (wrap == Wrap::MirroredRepeat) {
        t -= 2 * std::floor(0.5f * t);
        if (t > 1) t = 2 - t;
    } else if (t > 1) {
        t = 1;
    }
    return t >= 0 ? t : 0;
}

uint32_t nearest_texel(float t, Wrap wrap, uint32_t size) {
    const auto texel = static_cast<uint32_t>(fold(t, wrap) * static_cast<float>(size));
    return texel < size ? texel : size - 1;
}

inline Taps bilinear_taps(float t, Wrap wrap, uint32_t size) {
    const float x = fold(t, wrap) * static_cast<float>(size) - 0.5f;  // texel centres lie at whole numbers
    const float floor_x = std::floor(x);
    const auto last = static_cast<int32_t>(size) - 1;
    int32_t first = static_cast<int32_t>(floor_x);
    int32_t second = first + 1;
    if (wrap == Wrap::Repeat) {
        if (first < 0) first = last;
        if (second > last) second = 0;
    } else {  // beyond a mirrored or clamped edge lies the edge's own texel
        if (first < 0) first = 0;
        if (second > last) second = last;
    }
    if (first > last) first = last;  // float rounding at t = 1 in very wide images
    return {static_cast<uint32_t>(first), static_cast<uint32_t>(second), x - floor_x};
}

template <bool kSrgb>
vec4 decoded(const u8vec4& texel) {
    constexpr float kScale = 1.0f / 255.0f;
    if constexpr (kSrgb)
        return {kSrgbToLinear[texel.x], kSrgbToLinear[texel.y], kSrgbToLinear[texel.z],
                kScale * static_cast<float>(texel.w)};
    return kScale * vec4(texel);
}

template <bool kSrgb>
vec4 sample(const Texture& texture, vec2 uv) {
    const uint32_t width = texture.size.width;
    const u8vec4* texels = texture.texels.data();
    if (texture.nearest)
        return decoded<kSrgb>(texels[size_t{nearest_texel(uv.y, texture.wrap_t, texture.size.height)} * width +
                                     nearest_texel(uv.x, texture.wrap_s, width)]);
    const Taps s = bilinear_taps(uv.x, texture.wrap_s, width);
    const Taps t = bilinear_taps(uv.y, texture.wrap_t, texture.size.height);
    const u8vec4* row0 = texels + size_t{t.first} * width;
    const u8vec4* row1 = texels + size_t{t.second} * width;
    const vec4 top = (1 - s.weight) * decoded<kSrgb>(row0[s.first]) + s.weight * decoded<kSrgb>(row0[s.second]);
    const vec4 bottom = (1 - s.weight) * decoded<kSrgb>(row1[s.first]) + s.weight * decoded<kSrgb>(row1[s.second]);
    return (1 - t.weight) * top + t.weight * bottom;
}

}  // namespace

vec4 sample_texture(const Texture& texture, vec2 uv, bool srgb) {
    return srgb ? sample<true>(texture, uv) : sample<false>(texture, uv);
}

TextureLookup prepare_lookup(const Texture& texture, vec2 uv) {
    const size_t width = texture.size.width;
    const u8vec4* texels = texture.texels.data();
    if (texture.nearest) {
        const uint32_t column = nearest_texel(uv.x, texture.wrap_s, texture.size.width);
        const u8vec4* row = texels + nearest_texel(uv.y, texture.wrap_t, texture.size.height) * width;
        return {.row0 = row, .row1 = row, .first = column, .second = column, .weight_s = 0, .weight_t = 0};
    }
    const Taps s = bilinear_taps(uv.x, texture.wrap_s, texture.size.width);
    const Taps t = bilinear_taps(uv.y, texture.wrap_t, texture.size.height);
    return {.row0 = texels + t.first * width,
            .row1 = texels + t.second * width,
            .first = s.first,
            .second = s.second,
            .weight_s = s.weight,
            .weight_t = t.weight};
}

Rgb sample_srgb(const TextureLookup& lookup) {
    const auto color = [](const u8vec4& texel) {
        return Rgb(kSrgbToLinear[texel.x], kSrgbToLinear[texel.y], kSrgbToLinear[texel.z]);
    };
    const auto in_row = [&](const u8vec4* row) {
        return (1 - lookup.weight_s) * color(row[lookup.first]) + lookup.weight_s * color(row[lookup.second]);
    };
    return (1 - lookup.weight_t) * in_row(lookup.row0) + lookup.weight_t * in_row(lookup.row1);
}

void prefetch_texture(const Texture& texture, vec2 uv) { prefetch(prepare_lookup(texture, uv)); }

}  // namespace photond
