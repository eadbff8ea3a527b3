#pragma once
// Textures as a scene holds them: 8-bit texels as stored in the file, decoded at the lookup; and float environments.

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/core/rgb.h"

namespace photond {

enum class Wrap : uint8_t { Repeat, MirroredRepeat, ClampToEdge };

/// An 8-bit RGBA image, row 0 at v = 0 (glTF: the top). Colour textures are sRGB-encoded, data textures linear; one
/// image may be used as both, so the decoding is asked for at the lookup.
struct Texture {
    std::string name;
    Size2 size;
    std::vector<u8vec4> texels;
    Wrap wrap_s = Wrap::Repeat;
    Wrap wrap_t = Wrap::Repeat;
    bool nearest = false;  // magnification filter NEAREST; else bilinear

    uint64_t bytes() const { return texels.size() * sizeof(u8vec4); }
};

inline constexpr int32_t kNoTexture = -1;

/// Where a material reads a texture: which one, which set of coordinates, and KHR_texture_transform as an affine map
/// uv' = (dot(row_u, (u, v, 1)), dot(row_v, (u, v, 1))).
struct TextureRef {
    int32_t texture = kNoTexture;
    uint32_t uv_set = 0;
    vec3 row_u{1, 0, 0};
    vec3 row_v{0, 1, 0};

    bool used() const { return texture != kNoTexture; }
};

/// Filtered lookup. `srgb`: the first three channels are decoded by the sRGB curve before filtering. All in [0, 1].
vec4 sample_texture(const Texture& texture, vec2 uv, bool srgb);

/// Asks the memory for the texels of such a lookup, so that they are at hand a little later.
void prefetch_texture(const Texture& texture, vec2 uv);

/// The texels of a lookup and their weights: found once, asked for, and read later. Borrows the texture.
struct TextureLookup {
    const u8vec4 *row0, *row1;
    uint32_t first, second;    // columns
    float weight_s, weight_t;  // of the second column and of row1
};
TextureLookup prepare_lookup(const Texture& texture, vec2 uv);
inline void prefetch(const TextureLookup& lookup) {
    __builtin_prefetch(lookup.row0 + lookup.first);
    __builtin_prefetch(lookup.row1 + lookup.first);
}
/// The first three channels of sample_texture(), by the sRGB curve.
Rgb sample_srgb(const TextureLookup& lookup);

/// Equirectangular radiance map [W m^-2 sr^-1], row 0 at the zenith (+Y); the direction (0, 0, -1) is its centre
/// column.
struct EnvironmentMap {
    Size2 size;
    std::vector<Rgb> radiance;
};

}  // namespace photond
