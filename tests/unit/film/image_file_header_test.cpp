// A header is refused by its own bytes, with the fault and its place, before an image library takes its word for
// anything; and what the format allows is let through.

#include "renderer/film/image_file_header.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "protocol/error.h"

namespace photond::image_file_header_test {
namespace {

using Bytes = std::string;

template <class T>
Bytes number(T value) {
    Bytes bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    return bytes;
}

Bytes text(const Bytes& text) { return text + '\0'; }

Bytes attribute(const Bytes& name, const Bytes& type, const Bytes& value) {
    return text(name) + text(type) + number(static_cast<uint32_t>(value.size())) + value;
}

Bytes window(int32_t x0, int32_t y0, int32_t x1, int32_t y1) {
    return number(x0) + number(y0) + number(x1) + number(y1);
}

/// A file of 6 x 5 pixels, one half channel, uncompressed: what it consists of can be changed.
struct Exr {
    uint32_t version = 2;
    Bytes data_window = window(-1, 2, 4, 6);
    Bytes compression = number<uint8_t>(0);
    Bytes channels;
    Bytes more;          // attributes
    Bytes after_header;  // of a file that may have several parts
    size_t chunks = 5;   // rows
    size_t chunk_bytes = 20;
    uint64_t offset_shift = 0;

    Exr() { set_channels(1); }
    void set_channels(int count) {
        channels.clear();
        for (int i = 0; i < count; ++i)
            channels += text("c" + std::to_string(i)) + number<uint32_t>(1) + number<uint32_t>(0) +
                        number<uint32_t>(1) + number<uint32_t>(1);
        channels += '\0';
    }
    Bytes bytes() const {
        Bytes file = number<uint32_t>(20000630) + number(version) + attribute("channels", "chlist", channels) +
                     attribute("compression", "compression", compression) +
                     attribute("dataWindow", "box2i", data_window) + more + '\0' + after_header;
        const size_t pixels = file.size() + chunks * sizeof(uint64_t);
        for (size_t i = 0; i < chunks; ++i) file += number<uint64_t>(pixels + i * chunk_bytes + offset_shift);
        return file + Bytes(chunks * chunk_bytes, '\0');
    }
};

class ImageFileHeader : public testing::Test {
protected:
    ImageFileHeader()
        : path_(std::filesystem::temp_directory_path() / ("photond_header_" + std::to_string(getpid()))) {}
    ~ImageFileHeader() override { std::filesystem::remove(path_); }

    ImageFileFormat judge(const Bytes& bytes) const {
        std::ofstream(path_, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        return judge_image_file_header(path_);
    }
    /// The words of the refusal; empty when there was none.
    std::string refusal(const Bytes& bytes) const {
        try {
            judge(bytes);
            return "";
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::BadImage);
            return error.what();
        }
    }
    std::string refusal(const Exr& exr) const { return refusal(exr.bytes()); }

private:
    const std::filesystem::path path_;
};

TEST_F(ImageFileHeader, APlainFilePasses) {
    EXPECT_EQ(judge(Exr().bytes()), ImageFileFormat::OpenExr);
    EXPECT_EQ(judge("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n"), ImageFileFormat::Radiance);
}

TEST_F(ImageFileHeader, AttributesAreCounted) {
    Exr exr;
    for (uint32_t i = 3; i < kMaxHeaderAttributes; ++i)
        exr.more += attribute("a" + std::to_string(i), "int", number<uint32_t>(i));
    EXPECT_EQ(refusal(exr), "");
    exr.more += attribute("one more", "int", number<uint32_t>(1));
    EXPECT_EQ(refusal(exr), "its header has more than 1000 attributes");
}

TEST_F(ImageFileHeader, NamesAndSizesAreBounded) {
    Exr exr;
    exr.more = attribute(Bytes(32, 'n'), "int", number<uint32_t>(1));
    EXPECT_NE(refusal(exr).find("is longer than 31 bytes"), std::string::npos);
    exr.version |= 0x400;
    EXPECT_EQ(refusal(exr), "");
    exr.more = text("big") + text("string") + number<uint32_t>(UINT32_MAX) + "ab";
    EXPECT_NE(refusal(exr).find("its attribute 'big' says at byte"), std::string::npos);
    exr.more = attribute("big", "string", Bytes(kMaxHeaderBytes, 'x'));
    EXPECT_EQ(refusal(exr), "its header takes more than 16777216 bytes");
}

TEST_F(ImageFileHeader, ChannelsAndPixelsAreCounted) {
    Exr exr;
    exr.set_channels(kMaxImageChannels);
    EXPECT_EQ(refusal(exr), "");
    exr.set_channels(kMaxImageChannels + 1);
    EXPECT_EQ(refusal(exr), "it has more than 128 channels");
    exr.set_channels(0);
    EXPECT_EQ(refusal(exr), "it has no channels");
    exr.set_channels(1);
    exr.data_window = window(0, 0, 65535, 65535);
    EXPECT_EQ(refusal(exr), "it has 4294967296 pixels; the limit is 67108864");
    exr.data_window = window(INT32_MIN, INT32_MIN, INT32_MAX, INT32_MAX);
    EXPECT_EQ(refusal(exr), "it has 4294967296 pixels a row; the limit is 67108864");
    exr.data_window = window(0, 0, -1, 4);
    EXPECT_EQ(refusal(exr), "its data window is empty");
    exr.data_window = window(0, 0, 4, 4).substr(0, 15);
    EXPECT_EQ(refusal(exr), "its attribute 'dataWindow' takes 15 bytes, not 16");
}

TEST_F(ImageFileHeader, OnePartIsReadWhateverItsKind) {
    Exr exr;
    exr.version |= 0x1000;
    exr.after_header = Bytes(1, '\0');
    exr.more = attribute("type", "string", "scanlineimage");
    EXPECT_EQ(refusal(exr), "");
    exr.after_header = text("name") + text("string");
    EXPECT_EQ(refusal(exr), "it has several parts; one is expected");
    exr.after_header = Bytes(1, '\0');
    exr.more = attribute("type", "string", "deepscanline");
    EXPECT_EQ(refusal(exr), "deep data is not supported");
    Exr deep;
    deep.version |= 0x800;
    EXPECT_EQ(refusal(deep), "deep data is not supported");
    Exr old;
    old.version = 3;
    EXPECT_EQ(refusal(old), "it is OpenEXR of version 3, not 2");
}

TEST_F(ImageFileHeader, PixelsLieWithinTheFile) {
    Exr exr;
    exr.offset_shift = 20;  // the last one is the file's end
    EXPECT_NE(refusal(exr).find("its table of offsets puts pixels 4 at byte"), std::string::npos);
    exr.offset_shift = static_cast<uint64_t>(-8);  // into the table
    EXPECT_NE(refusal(exr).find("its table of offsets puts pixels 0 at byte"), std::string::npos);
    Exr tall;
    tall.data_window = window(0, 0, 0, 999'999);
    EXPECT_NE(refusal(tall).find("its table of offsets has 1000000 entries of 8 bytes"), std::string::npos);
    Exr unknown;
    unknown.compression = number<uint8_t>(10);
    EXPECT_EQ(refusal(unknown), "its compression is unknown, 10");
}

TEST_F(ImageFileHeader, TilesOfAllLevelsHaveOffsets) {
    const auto refusal_of = [&](uint32_t side, uint8_t mode, size_t chunks) {
        Exr exr;  // 6 x 5 pixels
        exr.version |= 0x200;
        exr.more = attribute("tiles", "tiledesc", number(side) + number(side) + number(mode));
        exr.chunks = chunks;
        exr.chunk_bytes = 1;  // so that an entry more would be found to be missing
        Bytes bytes = exr.bytes();
        bytes.resize(bytes.size() - (chunks - 1));
        return refusal(bytes);
    };
    // One level: 3 x 3 tiles of 2. Halved down, 6 x 5, 3 x 2, 1 x 1: and 2 x 1 and 1 tiles. Rounding up, 3 x 3 and 2 x
    // 2: and 2 x 2 and 1, 1. All pairs: (3 + 2 + 1) x (3 + 1 + 1).
    for (const auto& [mode, chunks] : {std::pair<uint8_t, size_t>{0, 9}, {1, 12}, {0x11, 15}, {2, 30}, {0x12, 49}}) {
        const std::string right = refusal_of(2, mode, chunks), fewer = refusal_of(2, mode, chunks - 1);
        EXPECT_TRUE(right.empty() || right.find("at byte") != std::string::npos) << int{mode} << ": " << right;
        EXPECT_NE(fewer.find("has " + std::to_string(chunks) + " entries"), std::string::npos)
            << int{mode} << ": " << fewer;
    }
    EXPECT_EQ(refusal_of(0, 0, 9), "its tiles are empty");
    EXPECT_EQ(refusal_of(2, 3, 9), "its tiles have levels of an unknown kind, 3");
    Exr none;
    none.version |= 0x200;
    EXPECT_EQ(refusal(none), "it has tiles, and no attribute 'tiles' that says how large");
}

TEST_F(ImageFileHeader, WhatEndsEarlyOrIsDamagedIsRefusedOrPasses) {
    const Bytes good = Exr().bytes();
    const size_t pixels = good.size() - 5 * 20;
    for (size_t length = 0; length < pixels; ++length) EXPECT_NE(refusal(good.substr(0, length)), "") << length;
    for (size_t at = 0; at < good.size(); ++at)
        for (const int flip : {0x01, 0x55, 0x80, 0xff}) {
            Bytes changed = good;
            changed[at] = static_cast<char>(changed[at] ^ flip);
            (void)refusal(changed);  // BadImage or nothing
        }
}

TEST_F(ImageFileHeader, RadianceHeadersEnd) {
    EXPECT_NE(refusal("#?RGBE\nFORMAT=32-bit_rle_rgbe\n"), "");
    EXPECT_NE(refusal("#?RGBE\n" + Bytes(5000, 'x') + "\n\n").find("its header goes on past byte"), std::string::npos);
    Bytes many = "#?RGBE\n";
    while (many.size() < kMaxRadianceHeaderBytes) many += "VIEW=1\n";
    EXPECT_NE(refusal(many + "\n-Y 1 +X 1\n").find("its header goes on past byte"), std::string::npos);
    EXPECT_EQ(refusal("\x89PNG and more"), "it is neither an OpenEXR nor a Radiance HDR file");
    EXPECT_EQ(refusal(""), "it is neither an OpenEXR nor a Radiance HDR file");
}

}  // namespace
}  // namespace photond::image_file_header_test
