#include "renderer/scene/image_header.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/error.h"

namespace photond {

namespace {

[[noreturn]] void bad(const std::string& detail) { throw Error(ErrorCode::BadImage, "", detail); }

/// Reads numbers of either byte order; past the end is an error.
class ByteReader {
public:
    explicit ByteReader(std::span<const uint8_t> bytes) : bytes_(bytes) {}

    size_t left() const { return bytes_.size() - at_; }
    void skip(uint64_t count) {
        if (count > left()) bad("the image is cut short");
        at_ += static_cast<size_t>(count);
    }
    uint8_t u8() {
        skip(1);
        return bytes_[at_ - 1];
    }
    uint32_t big(int count) {
        uint32_t value = 0;
        for (int i = 0; i < count; ++i) value = value << 8 | u8();
        return value;
    }
    uint32_t little32() {
        uint32_t value = 0;
        for (int i = 0; i < 4; ++i) value |= static_cast<uint32_t>(u8()) << (8 * i);
        return value;
    }
    std::string_view text_until(char end, size_t max_length) {
        const char* first = reinterpret_cast<const char*>(bytes_.data()) + at_;
        const std::string_view rest(first, std::min(left(), max_length));
        const size_t length = rest.find(end);
        if (length == std::string_view::npos) bad("the image's header is malformed");
        at_ += length + 1;
        return rest.substr(0, length);
    }

private:
    std::span<const uint8_t> bytes_;
    size_t at_ = 0;
};

bool starts_with(std::span<const uint8_t> bytes, std::string_view magic) {
    return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

/// The chunks are walked to the last one: the decoder loses memory each time it runs into the end of a cut file.
Size2 png_size(ByteReader in) {
    constexpr uint32_t kHeader = 0x49484452, kEnd = 0x49454e44;
    in.skip(8);
    if (in.big(4) != 13 || in.big(4) != kHeader) bad("the PNG does not begin with its header chunk");
    const uint32_t width = in.big(4);
    const Size2 size{width, in.big(4)};
    in.skip(9);  // the rest of the chunk, and its checksum
    while (true) {
        const uint32_t length = in.big(4);
        const uint32_t kind = in.big(4);
        in.skip(uint64_t{length} + 4);
        if (kind == kEnd) return size;
    }
}

/// ISO 10918-1, annex B: the first start-of-frame segment holds the size. Segments are walked to the end of the image,
/// since progressive scans each cost a pass over all pixels.
Size2 jpeg_size(ByteReader in) {
    constexpr int kMaxScans = 100;
    std::optional<Size2> size;
    int scans = 0;
    in.skip(2);
    while (true) {
        if (in.left() == 0) bad("the JPEG is cut short: it has no end marker");
        if (in.u8() != 0xff) continue;  // entropy-coded data
        uint8_t marker = 0xff;
        while (marker == 0xff) {
            if (in.left() == 0) bad("the JPEG is cut short: it has no end marker");
            marker = in.u8();
        }
        if (marker == 0xd9) break;
        if (marker <= 0x01 || (marker >= 0xd0 && marker <= 0xd8)) continue;  // stuffing and markers without a segment
        const uint32_t length = in.big(2);
        if (length < 2) bad("a segment of the JPEG has no length");
        const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
        if (frame && !size) {
            if (length < 8) bad("the JPEG's frame header is cut short");
            in.skip(1);
            const uint32_t height = in.big(2);
            size = Size2{in.big(2), height};
            in.skip(length - 7);
            continue;
        }
        if (marker == 0xda && ++scans > kMaxScans)
            bad("the JPEG has more than " + std::to_string(kMaxScans) + " scans");
        in.skip(length - 2);
    }
    if (!size || scans == 0) bad("the JPEG holds no image");
    return *size;
}

/// OpenEXR file layout: after magic and version, attributes of (name, type, size, value) up to an empty name.
Size2 exr_size(ByteReader in) {
    in.skip(4);
    const uint32_t version = in.little32();
    if ((version & 0xff) != 2) bad("the EXR has version " + std::to_string(version & 0xff) + ", not 2");
    if (version & 0x1800) bad("deep and multi-part EXR files are not accepted");
    while (true) {
        const std::string_view name = in.text_until('\0', 256);
        if (name.empty()) bad("the EXR has no data window");
        in.text_until('\0', 256);
        const uint32_t bytes = in.little32();
        if (name != "dataWindow") {
            in.skip(bytes);
            continue;
        }
        if (bytes != 16) bad("the EXR's data window is malformed");
        int64_t corner[4];
        for (int64_t& c : corner) c = static_cast<int32_t>(in.little32());
        const int64_t width = corner[2] - corner[0] + 1, height = corner[3] - corner[1] + 1;
        if (width <= 0 || height <= 0 || width > INT32_MAX || height > INT32_MAX) bad("the EXR's data window is empty");
        return {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
    }
}

/// Radiance: lines of text up to an empty one, then the resolution, "-Y height +X width".
Size2 hdr_size(ByteReader in) {
    constexpr int kMaxLines = 200;
    for (int line = 0;; ++line) {
        if (line > kMaxLines) bad("the HDR's header does not end");
        if (in.text_until('\n', 4096).empty()) break;
    }
    const std::string_view resolution = in.text_until('\n', 128);
    uint32_t number[2] = {0, 0};
    std::string_view rest = resolution;
    for (const auto& [axis, value] : {std::pair{"-Y ", &number[0]}, std::pair{"+X ", &number[1]}}) {
        const size_t at = rest.find(axis);
        if (at == std::string_view::npos) bad("the HDR's pixels are not stored from the top left, row by row");
        rest.remove_prefix(at + 3);
        const auto parsed = std::from_chars(rest.data(), rest.data() + rest.size(), *value);
        if (parsed.ec != std::errc()) bad("the HDR's resolution is malformed");
    }
    return {number[1], number[0]};
}

}  // namespace

ImageHeader read_image_header(std::span<const uint8_t> encoded) {
    ImageHeader header;
    const ByteReader in(encoded);
    if (starts_with(encoded, "\x89PNG\r\n\x1a\n"))
        header = {ImageFormat::Png, png_size(in)};
    else if (starts_with(encoded, "\xff\xd8\xff"))
        header = {ImageFormat::Jpeg, jpeg_size(in)};
    else if (starts_with(encoded, "\x76\x2f\x31\x01"))
        header = {ImageFormat::OpenExr, exr_size(in)};
    else if (starts_with(encoded, "#?RADIANCE") || starts_with(encoded, "#?RGBE"))
        header = {ImageFormat::RadianceHdr, hdr_size(in)};
    else
        bad("the image is none of PNG, JPEG, OpenEXR, Radiance HDR");
    if (header.size.width == 0 || header.size.height == 0) bad("the image has no pixels");
    return header;
}

void judge_image_size(const ImageHeader& header, uint64_t encoded_bytes, uint64_t texel_bytes, uint64_t max_pixels) {
    constexpr uint64_t kMaxRatio = 10'000;
    const std::string shown = std::to_string(header.size.width) + " x " + std::to_string(header.size.height);
    const uint64_t pixels = uint64_t{header.size.width} * header.size.height;
    if (pixels > max_pixels || std::max(header.size.width, header.size.height) > (1u << 20))
        bad("the image is " + shown + ", more than the limit of " + std::to_string(max_pixels) +
            " pixels (or 1048576 a side)");
    if (pixels * texel_bytes / kMaxRatio > encoded_bytes)
        bad("the image of " + shown + " is stored in " + std::to_string(encoded_bytes) +
            " bytes, less than a 10000th of its pixels");
}

}  // namespace photond
