// Images and raster passes: what is drawn where, blended how, and copied out.

#include "renderer/backends/gpu/raster_pass.h"

#include <gtest/gtest.h>

#include <numeric>

#include "renderer/core/geometry.h"
#include "tests/support/gpu_twin.h"

namespace photond::gpu::gpu_raster_test {
namespace {

constexpr uint32_t kSide = 8;  // of the images
constexpr VkFormat kFloats = VK_FORMAT_R32G32B32A32_SFLOAT;

struct Push {
    float clip = -1000;  // cuts nothing away
    float slope = 0;
};

using Triangle = std::array<vec3, 3>;
/// The pixels with x + y < 7; none lies on an edge.
Triangle upper_left(float depth) { return {vec3(-1, -1, depth), vec3(0.9f, -1, depth), vec3(-1, 0.9f, depth)}; }
Triangle all_pixels(float depth) { return {vec3(-1, -1, depth), vec3(3, -1, depth), vec3(-1, 3, depth)}; }

RasterOptions floats(Blend blend, bool depth = false) { return {.colors = {{kFloats, blend}}, .depth = depth}; }

class GpuRaster : public testing::Test {
protected:
    Device& device_ = test::gpu_device();
    Buffer fragments_ = make_buffer(device_, "test fragments", std::span<const uint32_t>(std::array{0u}));

    template <class T>
    Buffer make(const std::vector<T>& elements) {
        return make_buffer(device_, "test", std::span<const T>(elements));
    }
    std::unique_ptr<RasterPipeline> pipeline(const RasterOptions& options,
                                             const char* fragment = "tests/gpu/raster_triangles.frag") {
        return std::make_unique<RasterPipeline>(device_, "tests/gpu/raster_triangles.vert", fragment, sizeof(Push),
                                                options);
    }
    template <class T = vec4>
    std::vector<T> pixels(Image& image) {
        Buffer buffer(device_, "test pixels", image.packed_bytes());
        CommandList commands(device_);
        copy(commands, image, buffer);
        commands.submit();
        commands.wait();
        return read_back<T>(device_, buffer, image.packed_bytes() / sizeof(T));
    }
    uint32_t fragments() { return read_back<uint32_t>(device_, fragments_, 1).front(); }
};

void run(CommandList& commands) {
    commands.submit();
    commands.wait();
}

TEST_F(GpuRaster, ATriangleCoversItsPixels) {
    const auto drawn = pipeline(floats(Blend::None));
    Image image(device_, "test image", kFloats, kSide, kSide);
    Buffer corners = make<Triangle>({upper_left(0.5f)}), colors = make<vec4>({vec4(1, 2, 3, 4)});
    CommandList commands(device_);
    RasterPass pass(commands, *drawn, {{clear(image, std::array{9.0f, 8.0f, 7.0f, 6.0f})}, {}},
                    {read("corners", corners), read("colors", colors), read_write("fragments", fragments_)});
    pass.push(Push{});
    pass.draw(3);
    pass.end();
    run(commands);
    const std::vector<vec4> got = pixels(image);
    uint32_t covered = 0;
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            covered += x + y < 7;
            EXPECT_EQ(got[y * kSide + x], x + y < 7 ? vec4(1, 2, 3, 4) : vec4(9, 8, 7, 6)) << x << ' ' << y;
        }
    EXPECT_EQ(fragments(), covered);
}

TEST_F(GpuRaster, BlendingAddsEveryInstanceOfEveryPass) {
    const auto drawn = pipeline(floats(Blend::Add));
    Image image(device_, "test image", kFloats, kSide, kSide);
    std::vector<Triangle> triangles(40, all_pixels(0.5f));
    std::vector<vec4> all_colors;
    vec4 sum(0.5f, 0, 0, 0);
    for (uint32_t i = 0; i < triangles.size(); ++i) {  // sums of small multiples of a power of two are exact
        const auto x = static_cast<float>(i);
        all_colors.emplace_back(x, -x, 0.25f * x, 1);
        for (int pass = 0; pass < 3; ++pass) sum += all_colors.back();
    }
    Buffer corners = make(triangles), colors = make(all_colors);
    CommandList commands(device_);
    for (int i = 0; i < 3; ++i) {
        RasterPass pass(commands, *drawn,
                        {{i == 0 ? clear(image, std::array{0.5f, 0.0f, 0.0f, 0.0f}) : load(image)}, {}},
                        {read("corners", corners), read("colors", colors), read_write("fragments", fragments_)});
        pass.push(Push{});
        pass.draw(3, static_cast<uint32_t>(triangles.size()));
    }
    run(commands);
    for (const vec4& pixel : pixels(image)) EXPECT_EQ(pixel, sum);
    EXPECT_EQ(fragments(), 3 * triangles.size() * kSide * kSide);
}

TEST_F(GpuRaster, WithoutBlendingTheLastInstanceStays) {
    const auto drawn = pipeline(floats(Blend::None));
    Image image(device_, "test image", kFloats, kSide, kSide);
    Buffer corners = make<Triangle>({all_pixels(0.5f), all_pixels(0.5f)}), colors = make<vec4>({vec4(1), vec4(2)});
    CommandList commands(device_);
    {
        RasterPass pass(commands, *drawn, {{clear(image, std::array{0.0f, 0.0f, 0.0f, 0.0f})}, {}},
                        {read("corners", corners), read("colors", colors), read_write("fragments", fragments_)});
        pass.push(Push{});
        pass.draw(3, 2);
    }
    run(commands);
    for (const vec4& pixel : pixels(image)) EXPECT_EQ(pixel, vec4(2));
}

TEST_F(GpuRaster, NearerTrianglesStayInFrontAndDepthsCanBeRead) {
    const auto drawn = pipeline(floats(Blend::None, true));
    Image image(device_, "test image", kFloats, kSide, kSide);
    Image depths(device_, "test depths", VK_FORMAT_D32_SFLOAT, kSide, kSide);
    // Far, near on its part, farther than the near one again.
    Buffer corners = make<Triangle>({all_pixels(0.75f), upper_left(0.25f), all_pixels(0.5f)}),
           colors = make<vec4>({vec4(1), vec4(2), vec4(3)});
    CommandList commands(device_);
    {
        RasterPass pass(commands, *drawn, {{clear(image, std::array{0.0f, 0.0f, 0.0f, 0.0f})}, clear_depth(depths)},
                        {read("corners", corners), read("colors", colors), read_write("fragments", fragments_)});
        pass.push(Push{});
        pass.draw(3, 3);
    }
    {  // at the depth that is there: not nearer
        RasterPass pass(commands, *drawn, {{load(image)}, load(depths)},
                        {read("corners", corners), read("colors", colors), read_write("fragments", fragments_)});
        pass.push(Push{});
        pass.draw(3, 1);
    }
    run(commands);
    const std::vector<vec4> got = pixels(image);
    const std::vector<float> depth = pixels<float>(depths);
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            EXPECT_EQ(got[y * kSide + x], vec4(x + y < 7 ? 2.0f : 3.0f)) << x << ' ' << y;
            EXPECT_EQ(depth[y * kSide + x], x + y < 7 ? 0.25f : 0.5f) << x << ' ' << y;
        }
}

TEST_F(GpuRaster, ClipDistancesCutTrianglesWithinAViewport) {
    const auto drawn = pipeline(floats(Blend::Add));
    Image image(device_, "test image", kFloats, kSide, kSide);
    Buffer corners = make<Triangle>({all_pixels(0.5f)}), colors = make<vec4>({vec4(1)});
    CommandList commands(device_);
    {
        RasterPass pass(commands, *drawn, {{clear(image, std::array{0.0f, 0.0f, 0.0f, 0.0f})}, {}},
                        {read("corners", corners), read("colors", colors), read_write("fragments", fragments_)});
        pass.push(Push{.clip = 0.1f, .slope = 1});  // x + y > 0.1 of clip space stays
        pass.draw(3);
        pass.viewport({2, 4, 4, 4});
        pass.push(Push{.clip = 0});  // x > 0
        pass.draw(3);
        EXPECT_THROW(pass.viewport({5, 0, 4, 4}), Error);
        EXPECT_THROW(pass.viewport({0, 0, 0, 4}), Error);
    }
    run(commands);
    const std::vector<vec4> got = pixels(image);
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            // Pixels' middles are at (x + 0.5) / 4 - 1.
            const bool first = x + y >= 8, second = x >= 4 && x < 6 && y >= 4;
            EXPECT_EQ(got[y * kSide + x], vec4(float(first) + float(second))) << x << ' ' << y;
        }
}

TEST_F(GpuRaster, IndirectDrawsReadTheirSizeOnTheDevice) {
    const auto drawn = pipeline(floats(Blend::Add));
    Image image(device_, "test image", kFloats, kSide, kSide);
    Buffer corners = make<Triangle>({all_pixels(0.5f), all_pixels(0.5f), all_pixels(0.5f)}),
           colors = make<vec4>({vec4(1), vec4(2), vec4(4)}), size(device_, "test draw", 32);
    CommandList commands(device_);
    const std::array<uint32_t, 4> instances_of_3{3, 2, 0, 0};
    commands.fill(size, 0);
    commands.update(size, std::as_bytes(std::span(instances_of_3)), 16);
    RasterPass pass(commands, *drawn, {{clear(image, std::array{0.0f, 0.0f, 0.0f, 0.0f})}, {}},
                    {read("corners", corners), read("colors", colors), read_write("fragments", fragments_)}, &size);
    pass.push(Push{});
    pass.draw_indirect(16);
    pass.draw_indirect(0);  // of nothing
    pass.end();
    commands.fill(size, 0);
    run(commands);
    for (const vec4& pixel : pixels(image)) EXPECT_EQ(pixel, vec4(3));
}

TEST_F(GpuRaster, LayersAreDrawnOneByOneAndCopiedTogether) {
    const auto drawn = pipeline({.colors = {{VK_FORMAT_R32G32_UINT}}}, "tests/gpu/raster_pixels.frag");
    constexpr uint32_t kLayers = 3, kWidth = 5, kHeight = 3;
    Image image(device_, "test image", VK_FORMAT_R32G32_UINT, kWidth, kHeight, kLayers);
    Buffer corners = make<Triangle>({all_pixels(0.5f)});
    CommandList commands(device_);
    std::vector<Buffer> colors;
    for (uint32_t layer = 0; layer < kLayers; ++layer) {
        colors.push_back(make<vec4>({vec4(float(100 * layer), 0, 0, 0)}));
        RasterPass pass(commands, *drawn, {{clear(image, std::array{0u, 0u, 0u, 0u}, layer)}, {}},
                        {read("corners", corners), read("colors", colors.back())});
        pass.push(Push{});
        pass.draw(layer == 1 ? 0 : 3);
    }
    run(commands);
    const std::vector<uvec2> got = pixels<uvec2>(image);
    for (uint32_t layer = 0; layer < kLayers; ++layer)
        for (uint32_t y = 0; y < kHeight; ++y)
            for (uint32_t x = 0; x < kWidth; ++x)
                EXPECT_EQ(got[(layer * kHeight + y) * kWidth + x], layer == 1 ? uvec2(0) : uvec2(100 * layer + x, y));
}

TEST_F(GpuRaster, ImagesTakeWhatIsCopiedToThemAndMayBeDrawnOnto) {
    const auto drawn = pipeline(floats(Blend::Add));
    Image image(device_, "test image", kFloats, kSide, kSide);
    std::vector<float> numbers(1 + 4 * kSide * kSide);
    std::iota(numbers.begin(), numbers.end(), 0.0f);
    numbers.insert(numbers.begin(), 3, -1.0f);
    Buffer from = make(numbers), corners = make<Triangle>({upper_left(0.5f)}), colors = make<vec4>({vec4(1000)});
    CommandList commands(device_);
    copy(commands, from, image, 16);
    {
        RasterPass pass(commands, *drawn, {{load(image)}, {}},
                        {read("corners", corners), read("colors", colors), read_write("fragments", fragments_)});
        pass.push(Push{});
        pass.draw(3);
    }
    run(commands);
    const std::vector<vec4> got = pixels(image);
    for (uint32_t i = 0; i < kSide * kSide; ++i) {
        const auto first = static_cast<float>(1 + 4 * i);
        const float added = i % kSide + i / kSide < 7 ? 1000.0f : 0.0f;
        EXPECT_EQ(got[i], vec4(first, first + 1, first + 2, first + 3) + added) << i;
    }
}

TEST_F(GpuRaster, ImagesAreAccountedAndGoAway) {
    const auto before = device_.memory().structures();
    {
        const Image image(device_, "test accounts", kFloats, 100, 50, 2);
        EXPECT_GE(device_.memory().structures()["test accounts"], image.packed_bytes());
        EXPECT_EQ(image.packed_bytes(), 16u * 100 * 50 * 2);
    }
    EXPECT_EQ(device_.memory().structures(), before);
}

TEST_F(GpuRaster, WhatCannotBeMadeIsRefusedWithAReason) {
    const auto code_of = [](const auto& make) {
        try {
            make();
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()), "");
            return error.code;
        }
        ADD_FAILURE() << "made";
        return ErrorCode::Internal;
    };
    const auto before = device_.memory().structures();
    EXPECT_EQ(code_of([&] { Image(device_, "test", VK_FORMAT_R8G8B8A8_UNORM, 8, 8); }), ErrorCode::Internal);
    EXPECT_EQ(code_of([&] { Image(device_, "test", kFloats, 8, 0); }), ErrorCode::Internal);
    EXPECT_EQ(code_of([&] { Image(device_, "test", kFloats, 1u << 20, 8); }), ErrorCode::OutOfMemory);
    EXPECT_EQ(code_of([&] { Image(device_, "test", kFloats, 8, 8, 1u << 20); }), ErrorCode::OutOfMemory);
    // Whole numbers are blended by no device. [Vulkan 1.3, sec. 29.1]
    EXPECT_EQ(code_of([&] {
                  pipeline({.colors = {{VK_FORMAT_R32G32_UINT, Blend::Add}}}, "tests/gpu/raster_pixels.frag");
              }),
              ErrorCode::Unsupported);
    EXPECT_EQ(code_of([&] {
                  RasterPipeline(device_, "tests/gpu/raster_writing.vert", "tests/gpu/raster_pixels.frag", 0,
                                 {.colors = {{VK_FORMAT_R32G32_UINT}}});
              }),
              ErrorCode::Internal);
    EXPECT_EQ(device_.memory().structures(), before);
    // Two shaders that have different buffers at one binding.
    constexpr const char* kOther = "renderer/methods/photon_splatting/splat_volume.frag";
    try {
        pipeline(floats(Blend::None), kOther);
        ADD_FAILURE() << "made";
    } catch (const Error& error) {
        const std::string text = error.what();
        for (const char* part : {kOther, "eye", "corners"}) EXPECT_NE(text.find(part), std::string::npos) << text;
    }
}

/// Those of both shaders, whatever the order of the list.
TEST_F(GpuRaster, BuffersAreBoundByTheirNames) {
    const auto drawn = pipeline(floats(Blend::None));
    Image image(device_, "test image", kFloats, kSide, kSide);
    Buffer corners = make<Triangle>({all_pixels(0.5f)}), colors = make<vec4>({vec4(3)});
    CommandList commands(device_);
    RasterPass pass(commands, *drawn, {{clear(image, std::array{0.0f, 0.0f, 0.0f, 0.0f})}, {}},
                    {read_write("fragments", fragments_), read("colors", colors), read("corners", corners)});
    pass.push(Push{});
    pass.draw(3);
    pass.end();
    run(commands);
    EXPECT_EQ(fragments(), kSide * kSide);
    for (const vec4& pixel : pixels(image)) EXPECT_EQ(pixel, vec4(3));
}

TEST_F(GpuRaster, PassesThatDoNotFitAreRefused) {
    const auto drawn = pipeline(floats(Blend::None));
    Image image(device_, "test image", kFloats, kSide, kSide),
        depths(device_, "test depths", VK_FORMAT_D32_SFLOAT, 8, 8);
    Image numbers(device_, "test numbers", VK_FORMAT_R32G32_UINT, kSide, kSide);
    Buffer corners = make<Triangle>({upper_left(0.5f)}), colors = make<vec4>({vec4(1)});
    Buffer pixels(device_, "test pixels", image.packed_bytes());
    CommandList commands(device_);
    const Attachment cleared = clear(image, std::array{0.0f, 0.0f, 0.0f, 0.0f});
    const auto refused = [&](const RasterTargets& targets) {
        EXPECT_THROW(
            RasterPass(commands, *drawn, targets,
                       {read("corners", corners), read("colors", colors), read_write("fragments", fragments_)}),
            Error);
    };
    refused({{}, {}});
    refused({{cleared, cleared}, {}});
    refused({{cleared}, clear_depth(depths)});
    refused({{clear(numbers, std::array{0u, 0u, 0u, 0u})}, {}});
    refused({{load(image)}, {}});
    refused({{clear(image, std::array{0.0f, 0.0f, 0.0f, 0.0f}, 1)}, {}});
    EXPECT_THROW(RasterPass(commands, *drawn, {{cleared}, {}}, {read("corners", corners), read("colors", colors)}),
                 Error);
    EXPECT_THROW(copy(commands, image, pixels), Error);
    {
        RasterPass pass(commands, *drawn, {{cleared}, {}},
                        {read("corners", corners), read("colors", colors), read_write("fragments", fragments_)});
        EXPECT_THROW(pass.draw_indirect(), Error);
        EXPECT_THROW(commands.fill(pixels, 0), Error);  // in the midst of a pass
        EXPECT_THROW(copy(commands, image, pixels), Error);
    }
    EXPECT_THROW(commands.dispatch(1), Error);  // what the pass had bound is not bound any more
    EXPECT_THROW(copy(commands, image, pixels, 4), Error);
    run(commands);
}

}  // namespace
}  // namespace photond::gpu::gpu_raster_test
