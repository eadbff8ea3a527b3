// Texture lookups against the definition, and image decoding: what is stored is what is looked up.

#include "renderer/scene/texture.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>

#include "protocol/error.h"
#include "tests/support/test_gltf.h"

namespace photond::texture_test {
namespace {

Texture random_texture(Size2 size, Wrap wrap_s, Wrap wrap_t) {
    Texture texture;
    texture.size = size;
    texture.wrap_s = wrap_s;
    texture.wrap_t = wrap_t;
    uint32_t state = 12345;
    for (size_t i = 0; i < size.pixels(); ++i) {
        u8vec4 texel;
        for (int k = 0; k < 4; ++k) {
            state = state * 1664525u + 1013904223u;
            texel[k] = static_cast<uint8_t>(state >> 24);
        }
        texture.texels.push_back(texel);
    }
    return texture;
}

/// The texel coordinate that a wrap mode gives for any integer, by the definition of OpenGL ES 3.2, table 15.3.
int wrapped(int i, int size, Wrap wrap) {
    const auto modulo = [](int a, int n) { return (a % n + n) % n; };
    if (wrap == Wrap::Repeat) return modulo(i, size);
    if (wrap == Wrap::ClampToEdge) return std::clamp(i, 0, size - 1);
    const int j = modulo(i, 2 * size);
    return j < size ? j : 2 * size - 1 - j;
}

double srgb_decoded(double x) { return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4); }

double expected(const Texture& texture, double u, double v, int channel, bool srgb) {
    const auto width = static_cast<int>(texture.size.width), height = static_cast<int>(texture.size.height);
    const double x = u * width - 0.5, y = v * height - 0.5;
    double sum = 0;
    for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
            const int i = static_cast<int>(std::floor(x)) + dx, j = static_cast<int>(std::floor(y)) + dy;
            const double weight = (1 - std::fabs(x - i)) * (1 - std::fabs(y - j));
            const u8vec4 texel = texture.texels[static_cast<size_t>(wrapped(j, height, texture.wrap_t) * width +
                                                                    wrapped(i, width, texture.wrap_s))];
            const double value = texel[channel] / 255.0;
            sum += weight * (srgb && channel < 3 ? srgb_decoded(value) : value);
        }
    return sum;
}

TEST(Texture, BilinearLookupsFollowTheDefinitionForEachWrapMode) {
    for (const Wrap wrap_s : {Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge})
        for (const Wrap wrap_t : {Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge})
            for (const Size2 size : {Size2{1, 1}, Size2{1, 3}, Size2{4, 2}, Size2{7, 5}}) {
                const Texture texture = random_texture(size, wrap_s, wrap_t);
                // Irrational steps cover the cells of several periods without falling on their edges, where a float's
                // rounding may pick the neighbour (with weight 0).
                for (int i = 0; i < 400; ++i) {
                    const vec2 uv(-3.1f + 0.0157079f * static_cast<float>(i),
                                  2.9f - 0.0141421f * static_cast<float>(i));
                    for (const bool srgb : {false, true}) {
                        const vec4 value = sample_texture(texture, uv, srgb);
                        for (int k = 0; k < 4; ++k)
                            // The weights carry the float rounding of u x width: 4 x 7 x 2^-23 for texels that differ
                            // by 1.
                            ASSERT_NEAR(value[k], expected(texture, double{uv.x}, double{uv.y}, k, srgb), 1e-5)
                                << "uv " << uv.x << ", " << uv.y;
                    }
                }
            }
}

TEST(Texture, NearestLookupsGiveTheTexelItself) {
    Texture texture = random_texture({5, 3}, Wrap::Repeat, Wrap::ClampToEdge);
    texture.nearest = true;
    for (int j = 0; j < 3; ++j)
        for (int i = -5; i < 10; ++i) {
            const vec2 uv((static_cast<float>(i) + 0.3f) / 5, (static_cast<float>(j) + 0.8f) / 3);
            const u8vec4 texel = texture.texels[static_cast<size_t>(j * 5 + wrapped(i, 5, Wrap::Repeat))];
            EXPECT_NEAR(sample_texture(texture, uv, false).x, static_cast<float>(texel.x) / 255.0f, 1e-6f);
            EXPECT_NEAR(sample_texture(texture, uv, true).w, static_cast<float>(texel.w) / 255.0f, 1e-6f);
        }
}

TEST(Texture, CoordinatesWithoutMeaningStayInside) {
    for (const bool nearest : {false, true})
        for (const Wrap wrap : {Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge}) {
            Texture texture = random_texture({3, 2}, wrap, wrap);
            texture.nearest = nearest;
            for (const float t : {std::nanf(""), kInfinity, -kInfinity, 1e30f, -1e30f, 1.0f, -0.0f, -1e-10f,
                                  0.99999994f, 2147483648.0f}) {
                const vec4 value = sample_texture(texture, vec2(t, -t), true);
                for (int k = 0; k < 4; ++k) EXPECT_TRUE(value[k] >= 0 && value[k] <= 1) << t;
            }
        }
}

TEST(TextureDecode, PngTexelsComeBackAsStored) {
    // Alpha 0 keeps its colour: nothing is multiplied in.
    const std::vector<u8vec4> texels = {{255, 0, 7, 0},     {1, 2, 3, 4}, {250, 251, 252, 253},
                                        {0, 128, 255, 255}, {9, 8, 7, 1}, {77, 66, 55, 128}};
    const Texture texture = decode_texture(make_png({3, 2}, texels), {});
    EXPECT_EQ(texture.size, (Size2{3, 2}));
    EXPECT_EQ(texture.texels, texels);
}

/// A picture of the kind's own making, through the library.
std::vector<uint8_t> encode(const std::string& name, Size2 size, int channels, OIIO::TypeDesc type,
                            const std::vector<float>& values) {
    const TemporaryFolder folder;
    const std::string path = (folder.path() / name).string();
    const auto out = OIIO::ImageOutput::create(path);
    OIIO::ImageSpec spec(static_cast<int>(size.width), static_cast<int>(size.height), channels, type);
    spec.attribute("CompressionQuality", 100);
    if (!out || !out->open(path, spec) || !out->write_image(OIIO::TypeDesc::FLOAT, values.data()) || !out->close())
        throw std::runtime_error("cannot write " + path);
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(TextureDecode, GreyAndJpegAndSixteenBitsBecomeRgba) {
    const Texture grey = decode_texture(encode("g.png", {2, 1}, 1, OIIO::TypeDesc::UINT8, {0.2f, 1}), {});
    EXPECT_EQ(grey.texels, (std::vector<u8vec4>{{51, 51, 51, 255}, {255, 255, 255, 255}}));
    const Texture grey_alpha = decode_texture(encode("ga.png", {1, 1}, 2, OIIO::TypeDesc::UINT8, {0.4f, 0.2f}), {});
    EXPECT_EQ(grey_alpha.texels.front().x, grey_alpha.texels.front().z);
    EXPECT_EQ(grey_alpha.texels.front().w, 51);
    const Texture wide = decode_texture(encode("w.png", {1, 1}, 3, OIIO::TypeDesc::UINT16, {0.2f, 0.4f, 0.6f}), {});
    EXPECT_EQ(wide.texels, (std::vector<u8vec4>{{51, 102, 153, 255}}));
    const std::vector<float> flat(16 * 16 * 3, 0.4f);
    const Texture jpeg = decode_texture(encode("j.jpg", {16, 16}, 3, OIIO::TypeDesc::UINT8, flat), {});
    ASSERT_EQ(jpeg.texels.size(), 256u);
    for (const u8vec4& texel : jpeg.texels) EXPECT_NEAR(texel.y, 102, 1);
    const Texture grey_jpeg = decode_texture(encode("j.jpg", {8, 8}, 1, OIIO::TypeDesc::UINT8, flat), {});
    EXPECT_NEAR(grey_jpeg.texels[20].z, 102, 1);
}

ErrorCode decoding_error(std::span<const uint8_t> bytes, const LoadLimits& limits = {}) {
    try {
        decode_texture(bytes, limits);
    } catch (const Error& error) {
        return error.code;
    }
    return ErrorCode::Internal;
}

TEST(TextureDecode, WhatIsTooLargeOrCutIsRefused) {
    const std::vector<u8vec4> texels(64, u8vec4(9));
    std::vector<uint8_t> png = make_png({8, 8}, texels);
    EXPECT_EQ(decoding_error(png, {.max_texture_pixels = 63}), ErrorCode::BadImage);
    EXPECT_NO_THROW(decode_texture(png, {.max_texture_pixels = 64}));
    std::vector<uint8_t> jpeg = encode("j.jpg", {16, 16}, 3, OIIO::TypeDesc::UINT8, std::vector<float>(768, 0.5f));
    EXPECT_EQ(decoding_error(jpeg, {.max_texture_pixels = 255}), ErrorCode::BadImage);
    for (size_t length = 0; length < png.size(); ++length)
        ASSERT_EQ(decoding_error(std::span(png).first(length)), ErrorCode::BadImage) << length;
    for (size_t length = 0; length < jpeg.size(); ++length)
        ASSERT_EQ(decoding_error(std::span(jpeg).first(length)), ErrorCode::BadImage) << length;
    const auto exr = encode("e.exr", {4, 4}, 3, OIIO::TypeDesc::FLOAT, std::vector<float>(48, 0.5f));
    EXPECT_EQ(decoding_error(exr), ErrorCode::BadImage) << "an EXR is no texture";
}

TEST(EnvironmentDecode, ExrKeepsItsFloatsAndHdrItsEightBits) {
    const std::vector<float> values = {0, 1e-5f, 1, 1e4f, 3.14159f, 0.125f};
    const EnvironmentMap exr = decode_environment(encode("e.exr", {2, 1}, 3, OIIO::TypeDesc::FLOAT, values), {});
    EXPECT_EQ(exr.size, (Size2{2, 1}));
    EXPECT_EQ(exr.radiance, (std::vector<Rgb>{{0, 1e-5f, 1}, {1e4f, 3.14159f, 0.125f}}));
    const std::vector<float> soft = {0.5f, 1, 0.75f, 100, 50, 25};
    const EnvironmentMap hdr = decode_environment(encode("e.hdr", {2, 1}, 3, OIIO::TypeDesc::FLOAT, soft), {});
    ASSERT_EQ(hdr.radiance.size(), 2u);
    // RGBE shares an exponent: each channel is kept to 1/256 of the greatest one's power of two.
    for (size_t i = 0; i < 2; ++i)
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(hdr.radiance[i][k], soft[3 * i + static_cast<size_t>(k)], i == 0 ? 2.0 / 256 : 128.0 / 256);
    const EnvironmentMap grey = decode_environment(encode("g.exr", {1, 1}, 1, OIIO::TypeDesc::FLOAT, {2.5f}), {});
    EXPECT_EQ(grey.radiance, (std::vector<Rgb>{{2.5f, 2.5f, 2.5f}}));
}

TEST(EnvironmentDecode, WhatIsNoRadianceIsRefused) {
    for (const float wrong : {-1.0f, std::nanf(""), kInfinity}) {
        const auto bytes = encode("e.exr", {2, 1}, 3, OIIO::TypeDesc::FLOAT, {1, 1, 1, 1, wrong, 1});
        EXPECT_THROW(decode_environment(bytes, {}), Error) << wrong;
    }
    const auto bytes = encode("e.exr", {8, 8}, 3, OIIO::TypeDesc::FLOAT, std::vector<float>(192, 1.0f));
    EXPECT_THROW(decode_environment(bytes, {.max_texture_pixels = 63}), Error);
    EXPECT_EQ(judge_environment(bytes, {}).size, (Size2{8, 8}));
    for (size_t length = 0; length < bytes.size(); length += 3)
        EXPECT_THROW(decode_environment(std::span(bytes).first(length), {}), Error) << length;
    EXPECT_THROW(judge_environment(make_png({1, 1}, {u8vec4(1)}), {}), Error);
}

}  // namespace
}  // namespace photond::texture_test
