// What is written is what a reader of the format finds: names, values, precision, header; and what is no image of ours
// is refused before it costs anything.

#include "renderer/film/exr_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "protocol/error.h"
#include "renderer/core/rng.h"
#include "renderer/film/png_file.h"

namespace photond::exr_file_test {
namespace {

class ExrFile : public testing::Test {
protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() / ("photond_exr_test_" + std::to_string(getpid()));
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::filesystem::path file(const std::string& name) const { return folder_ / name; }
    static std::string bytes_of(const std::filesystem::path& path) {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    static void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
        std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
    }

private:
    std::filesystem::path folder_;
};

LayerSet every_layer() {
    LayerSet layers;
    for (const LayerInfo& info : kLayers) layers.add(info.layer);
    return layers;
}

/// 300 rows: more than one band of the writer, the last one cut.
Film test_film(Size2 size = {65, 300}) {
    Film film(size, every_layer());
    for (uint32_t p = 0; p < 2; ++p) {
        PassImage pass(size, every_layer());
        for (size_t i = 0; i < size.pixels(); ++i) {
            RandomStream random(5, RandomDomain::Test, p, i);
            const auto rgb = [&] { return Rgb(random.next(), random.next(), random.next()); };
            pass.of<Layer::Emitted>()[i] = rgb(), pass.of<Layer::Direct>()[i] = rgb(),
            pass.of<Layer::Indirect>()[i] = rgb(), pass.of<Layer::Caustic>()[i] = rgb();
            pass.of<Layer::Albedo>()[i] = rgb(), pass.of<Layer::Normal>()[i] = -rgb(),
            pass.of<Layer::Position>()[i] = 100.0f * rgb();
            pass.of<Layer::Depth>()[i] = 10 * random.next();
            pass.of<Layer::PhotonCount>()[i] = std::floor(100 * random.next());
            pass.hit[i] = i % 3 != 0;
        }
        film.add_pass(pass);
    }
    return film;
}

ErrorCode code_of_reading(const std::filesystem::path& path) {
    try {
        (void)read_exr(path);
    } catch (const Error& error) {
        return error.code;
    }
    return ErrorCode::Internal;
}

TEST_F(ExrFile, FloatKeepsEveryBitOfEveryLayer) {
    const Film film = test_film();
    EXPECT_EQ(write_exr(film, Precision::Float, {}, file("a.exr")), 0u);
    const LayeredImage image = read_exr(file("a.exr"));
    EXPECT_EQ(image.size, film.size());
    EXPECT_EQ(image.layers.size(), 1 + kLayerCount);
    EXPECT_EQ(image.layers.at("beauty"), film.resolve_beauty());
    for (const LayerInfo& info : kLayers)
        EXPECT_EQ(image.layers.at(std::string(info.name)), film.resolve(info.layer)) << info.name;
}

TEST_F(ExrFile, HalfRoundsToElevenBits) {
    const Film film = test_film();
    EXPECT_EQ(write_exr(film, Precision::Half, {}, file("a.exr")), 0u);
    const LayeredImage image = read_exr(file("a.exr"));
    const std::vector<float> expected = film.resolve_beauty(), &found = image.layers.at("beauty");
    for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(found[i], expected[i], expected[i] * 0x1p-11f + 0x1p-24f);
}

TEST_F(ExrFile, WhatHalfCannotHoldIsInfiniteAndCounted) {
    Film film({4, 1}, LayerSet());
    PassImage pass({4, 1}, LayerSet());
    pass.of<Layer::Emitted>()[0] = Rgb(65504.0f, 65505.0f, 65520.0f);
    pass.of<Layer::Emitted>()[1] = Rgb(-65504.0f, -65519.0f, 1e8f);
    film.add_pass(pass);
    constexpr uint64_t kLayersThatHoldThem = 2;  // beauty and emitted
    EXPECT_EQ(write_exr(film, Precision::Half, {}, file("a.exr")), 4 * kLayersThatHoldThem);
    const LayeredImage image = read_exr(file("a.exr"));
    const std::vector<float>& beauty = image.layers.at("beauty");
    EXPECT_EQ((std::vector<float>(beauty.begin(), beauty.begin() + 6)),
              (std::vector<float>{65504.0f, kInfinity, kInfinity, -65504.0f, -kInfinity, kInfinity}));
    EXPECT_EQ(write_exr(film, Precision::Float, {}, file("a.exr")), 0u);
    EXPECT_EQ(read_exr(file("a.exr")).layers.at("beauty")[5], 1e8f);

    uint64_t overflowed = 0;
    const std::vector<float> values{1.0f, 65504.0f, 65505.0f, -1e9f, 0x1p-24f};
    EXPECT_EQ(to_half(values, overflowed), (std::vector<uint16_t>{0x3c00, 0x7bff, 0x7c00, 0xfc00, 0x0001}));
    EXPECT_EQ(overflowed, 2u);
}

/// Bytes of an attribute's value in an OpenEXR header (name, 0, type, 0, size, value).
std::string attribute(const std::string& exr, const std::string& name, const std::string& type) {
    const std::string key = name + '\0' + type + '\0';
    const size_t at = exr.find('\0' + key) == std::string::npos ? exr.find(key) : exr.find('\0' + key) + 1;
    if (at == std::string::npos) return "";
    int32_t size;
    std::memcpy(&size, exr.data() + at + key.size(), sizeof size);
    return exr.substr(at + key.size() + sizeof size, size_t(size));
}

TEST_F(ExrFile, TheHeaderSaysWhatTheProtocolPromises) {
    const std::vector<ImageAttribute> attributes{{"photond:memory.peak_resident_bytes", 123456789012.0},
                                                 {"photond:pixel_hash", std::string("abc")}};
    write_exr(test_film(), Precision::Float, attributes, file("a.exr"));
    const std::string exr = bytes_of(file("a.exr"));
    const std::string chromaticities = attribute(exr, "chromaticities", "chromaticities");
    ASSERT_EQ(chromaticities.size(), 8 * sizeof(float));
    float xy[8];
    std::memcpy(xy, chromaticities.data(), sizeof xy);
    const float rec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
    for (int i = 0; i < 8; ++i) EXPECT_FLOAT_EQ(xy[i], rec709[i]);
    EXPECT_EQ(attribute(exr, "compression", "compression"), std::string(1, 3));  // ZIP, 16 rows a block
    EXPECT_EQ(attribute(exr, "photond:pixel_hash", "string"), "abc");
    double number = 0;
    const std::string value = attribute(exr, "photond:memory.peak_resident_bytes", "double");
    ASSERT_EQ(value.size(), sizeof number);
    std::memcpy(&number, value.data(), sizeof number);
    EXPECT_EQ(number, 123456789012.0);
    EXPECT_EQ(exr.find("capDate"), std::string::npos);
    for (const char* channel : {"R", "emitted.G", "normal.Z", "depth.Z", "photon_count.Y"})
        EXPECT_NE(exr.find(std::string(1, '\0') + channel + '\0'), std::string::npos) << channel;
    EXPECT_EQ(uint8_t(exr[5]) & 0x12, 0);  // neither tiled nor of several parts
}

TEST_F(ExrFile, TheSameFilmGivesTheSameBytes) {
    const Film film = test_film();
    write_exr(film, Precision::Half, {}, file("a.exr"));
    write_exr(film, Precision::Half, {}, file("b.exr"));
    EXPECT_EQ(bytes_of(file("a.exr")), bytes_of(file("b.exr")));
    EXPECT_FALSE(std::filesystem::exists(file("a.exr.part")));
}

TEST_F(ExrFile, DamageIsBadImageOrFoundOutByDecoding) {
    write_exr(test_film({40, 40}), Precision::Half, {}, file("good.exr"));
    const std::string good = bytes_of(file("good.exr"));
    EXPECT_EQ(judge_image(file("good.exr")).size, (Size2{40, 40}));
    write_bytes(file("bad.exr"), "");
    EXPECT_EQ(code_of_reading(file("bad.exr")), ErrorCode::BadImage);
    write_bytes(file("bad.exr"), "\x89PNG\r\n\x1a\n and more");
    EXPECT_EQ(code_of_reading(file("bad.exr")), ErrorCode::BadImage);
    for (size_t length = 4; length < good.size(); length += good.size() / 40) {
        write_bytes(file("bad.exr"), good.substr(0, length));
        EXPECT_EQ(code_of_reading(file("bad.exr")), ErrorCode::BadImage) << length;
        EXPECT_THROW((void)judge_image(file("bad.exr")), Error) << length;
    }
    // A changed byte may make another valid image; it must never do worse than BadImage.
    for (size_t at = 0; at < good.size(); at += at < 600 ? 1 : 97) {
        std::string changed = good;
        changed[at] = char(changed[at] ^ 0x55);
        write_bytes(file("bad.exr"), changed);
        try {
            (void)read_exr(file("bad.exr"));
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::BadImage) << at;
        }
    }
}

TEST_F(ExrFile, ASizePastTheLimitIsRefusedByTheHeader) {
    write_exr(test_film({40, 40}), Precision::Half, {}, file("a.exr"));
    std::string exr = bytes_of(file("a.exr"));
    for (const char* name : {"dataWindow", "displayWindow"}) {
        const std::string key = std::string(name) + '\0' + "box2i" + '\0';
        const size_t at = exr.find(key) + key.size() + sizeof(int32_t);
        const int32_t window[4] = {0, 0, 65535, 65535};
        std::memcpy(exr.data() + at, window, sizeof window);
    }
    write_bytes(file("a.exr"), exr);
    EXPECT_EQ(code_of_reading(file("a.exr")), ErrorCode::BadImage);
    EXPECT_THROW((void)judge_image(file("a.exr")), Error);
}

TEST_F(ExrFile, OnlyRegularFilesAreRead) {
    write_exr(test_film({8, 8}), Precision::Half, {}, file("a.exr"));
    std::filesystem::create_symlink(file("a.exr"), file("link.exr"));
    EXPECT_EQ(code_of_reading(file("link.exr")), ErrorCode::BadImage);
    EXPECT_EQ(code_of_reading(file("none.exr")), ErrorCode::BadImage);
}

TEST_F(ExrFile, APngHasNoDateAndTheSameBytes) {
    const std::vector<uint8_t> pixels(3 * 20 * 10, 77);
    write_png({20, 10}, pixels, file("a.png"));
    write_png({20, 10}, pixels, file("b.png"));
    const std::string png = bytes_of(file("a.png"));
    EXPECT_EQ(png, bytes_of(file("b.png")));
    EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
    EXPECT_EQ(png.find("tIME"), std::string::npos);
}

}  // namespace
}  // namespace photond::exr_file_test
