#include "tests/support/test_gltf.h"

namespace photond {

namespace {

void put_big32(std::vector<uint8_t>& out, uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<uint8_t>(value >> shift));
}

uint32_t crc32(std::span<const uint8_t> bytes) {
    uint32_t crc = 0xffffffff;
    for (const uint8_t byte : bytes) {
        crc ^= byte;
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
    }
    return ~crc;
}

void put_chunk(std::vector<uint8_t>& out, const char* kind, const std::vector<uint8_t>& body) {
    put_big32(out, static_cast<uint32_t>(body.size()));
    const size_t start = out.size();
    out.insert(out.end(), kind, kind + 4);
    out.insert(out.end(), body.begin(), body.end());
    put_big32(out, crc32(std::span(out).subspan(start)));
}

}  // namespace

std::vector<uint8_t> make_png(Size2 size, const std::vector<u8vec4>& texels) {
    std::vector<uint8_t> rows;
    for (uint32_t y = 0; y < size.height; ++y) {
        rows.push_back(0);  // no filter
        for (uint32_t x = 0; x < size.width; ++x)
            for (int k = 0; k < 4; ++k) rows.push_back(texels[size_t{y} * size.width + x][k]);
    }
    // A zlib stream of one stored block, which holds at most 65,535 bytes.
    const auto length = static_cast<uint16_t>(rows.size());
    std::vector<uint8_t> stream = {0x78, 0x01, 1};
    for (const uint16_t word : {length, static_cast<uint16_t>(~length)}) {
        stream.push_back(static_cast<uint8_t>(word & 0xff));
        stream.push_back(static_cast<uint8_t>(word >> 8));
    }
    stream.insert(stream.end(), rows.begin(), rows.end());
    uint32_t a = 1, b = 0;
    for (const uint8_t byte : rows) a = (a + byte) % 65521, b = (b + a) % 65521;
    put_big32(stream, b << 16 | a);

    std::vector<uint8_t> header;
    put_big32(header, size.width);
    put_big32(header, size.height);
    header.insert(header.end(), {8, 6, 0, 0, 0});
    std::vector<uint8_t> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    put_chunk(png, "IHDR", header);
    put_chunk(png, "IDAT", stream);
    put_chunk(png, "IEND", {});
    return png;
}

}  // namespace photond
