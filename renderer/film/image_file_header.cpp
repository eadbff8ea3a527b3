#include "renderer/film/image_file_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/error.h"

namespace photond {

namespace {

[[noreturn]] void bad_image(const std::string& why) { throw Error(ErrorCode::BadImage, why); }

/// A file read from its begin to its end, little-endian; what is not there is BadImage.
class Reader {
public:
    explicit Reader(const std::filesystem::path& path)
        : file_(path, std::ios::binary), size_(std::filesystem::file_size(path)) {}

    uint64_t at() const { return at_; }
    uint64_t size() const { return size_; }
    uint64_t left() const { return size_ - at_; }

    void read(std::span<char> out) {
        if (out.size() > left() || !file_.read(out.data(), static_cast<std::streamsize>(out.size())))
            bad_image("it ends within its header, at byte " + std::to_string(at_));
        at_ += out.size();
    }
    template <class T>
    T number() {
        std::array<char, sizeof(T)> bytes;
        read(bytes);
        T value;
        std::memcpy(&value, bytes.data(), sizeof value);
        return value;
    }
    void skip(uint64_t bytes) {
        if (bytes > left() || !file_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur))
            bad_image("it ends within its header, at byte " + std::to_string(at_));
        at_ += bytes;
    }
    /// Up to a zero byte.
    std::string text(size_t most_bytes) {
        const uint64_t begin = at_;
        std::string text;
        while (const char next = number<char>()) {
            if (text.size() == most_bytes)
                bad_image("a name at byte " + std::to_string(begin) + " of its header is longer than " +
                          std::to_string(most_bytes) + " bytes");
            text += next;
        }
        return text;
    }

private:
    std::ifstream file_;
    const uint64_t size_;
    uint64_t at_ = 0;
};

// --- OpenEXR

constexpr uint32_t kExrMagic = 20000630;
constexpr uint32_t kExrVersion = 2;
enum ExrFlag : uint32_t { kTiled = 0x200, kLongNames = 0x400, kDeep = 0x800, kPartsPossible = 0x1000 };
/// Rows of pixels that are compressed together, by the attribute "compression": none, RLE, ZIPS, ZIP, PIZ, PXR24, B44,
/// B44A, DWAA, DWAB.
constexpr std::array<uint32_t, 10> kRowsOfChunk = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};

struct Tiles {
    uint32_t width = 0, height = 0;
    uint8_t levels = 0;  // 0: one; 1: a pyramid; 2: one for each pair of halvings
    bool rounds_up = false;
};

/// What the table of offsets depends on.
struct ExrHeader {
    std::optional<std::array<int32_t, 4>> data_window;  // x, y of the first and of the last pixel
    std::optional<uint8_t> compression;
    std::optional<Tiles> tiles;
    std::string type;  // of a part, where the file may have several
    uint32_t channels = 0;

    uint64_t width() const { return extent(0); }
    uint64_t height() const { return extent(1); }

private:
    uint64_t extent(size_t axis) const {
        const int64_t extent = int64_t{(*data_window)[axis + 2]} - (*data_window)[axis] + 1;
        if (extent <= 0) bad_image("its data window is empty");
        return static_cast<uint64_t>(extent);
    }
};

uint32_t count_channels(Reader& reader, uint64_t end, size_t most_name) {
    constexpr uint64_t kBytesBesideName = 16;  // type, linearity, both samplings
    uint32_t channels = 0;
    while (reader.at() < end) {
        if (reader.text(most_name).empty()) break;
        if (++channels > kMaxImageChannels)
            bad_image("it has more than " + std::to_string(kMaxImageChannels) + " channels");
        reader.skip(kBytesBesideName);
    }
    return channels;
}

void read_attribute(Reader& reader, const std::string& name, uint64_t bytes, size_t most_name, ExrHeader& header) {
    const uint64_t end = reader.at() + bytes;
    const auto of_size = [&](uint64_t expected) {
        if (bytes != expected)
            bad_image("its attribute '" + name + "' takes " + std::to_string(bytes) + " bytes, not " +
                      std::to_string(expected));
    };
    if (name == "dataWindow") {
        of_size(sizeof(std::array<int32_t, 4>));
        header.data_window = reader.number<std::array<int32_t, 4>>();
    } else if (name == "compression") {
        of_size(1);
        header.compression = reader.number<uint8_t>();
    } else if (name == "tiles") {
        of_size(9);
        Tiles tiles;
        tiles.width = reader.number<uint32_t>(), tiles.height = reader.number<uint32_t>();
        const auto mode = reader.number<uint8_t>();
        tiles.levels = mode & 0xf, tiles.rounds_up = mode >> 4 == 1;
        header.tiles = tiles;
    } else if (name == "type") {
        for (uint64_t i = 0; i < bytes; ++i) header.type += reader.number<char>();
    } else if (name == "channels") {
        header.channels = count_channels(reader, end, most_name);
    }
    if (reader.at() > end) bad_image("its attribute '" + name + "' is longer than it says");
    reader.skip(end - reader.at());
}

ExrHeader read_exr_header(Reader& reader, size_t most_name) {
    ExrHeader header;
    for (uint32_t count = 0;; ++count) {
        const std::string name = reader.text(most_name);
        if (name.empty()) return header;
        if (count == kMaxHeaderAttributes)
            bad_image("its header has more than " + std::to_string(kMaxHeaderAttributes) + " attributes");
        (void)reader.text(most_name);  // the type
        const uint64_t at = reader.at();
        const auto bytes = reader.number<uint32_t>();
        if (bytes > reader.left())
            bad_image("its attribute '" + name + "' says at byte " + std::to_string(at) + " that it takes " +
                      std::to_string(bytes) + " bytes; the file has " + std::to_string(reader.left()) + " more");
        if (reader.at() + bytes > kMaxHeaderBytes)
            bad_image("its header takes more than " + std::to_string(kMaxHeaderBytes) + " bytes");
        read_attribute(reader, name, bytes, most_name, header);
    }
}

uint64_t divide_up(uint64_t a, uint64_t b) { return (a + b - 1) / b; }

/// Sizes of one side, halved down to 1; the first alone where there is one level.
std::vector<uint64_t> level_sizes(uint64_t size, uint64_t levels, bool rounds_up) {
    std::vector<uint64_t> sizes;
    for (uint64_t level = 0; level < levels; ++level)
        sizes.push_back(std::max<uint64_t>(1, rounds_up ? divide_up(size, uint64_t{1} << level) : size >> level));
    return sizes;
}

uint64_t count_levels(uint64_t size, bool rounds_up) {
    uint64_t levels = 1;
    for (uint64_t left = size; left > 1; left = rounds_up ? divide_up(left, 2) : left / 2) ++levels;
    return levels;
}

/// Chunks of pixels, each with an entry in the table of offsets.
uint64_t count_chunks(const ExrHeader& header, bool tiled) {
    if (!tiled) return divide_up(header.height(), kRowsOfChunk[*header.compression]);
    if (!header.tiles) bad_image("it has tiles, and no attribute 'tiles' that says how large");
    const Tiles& tiles = *header.tiles;
    if (tiles.width == 0 || tiles.height == 0) bad_image("its tiles are empty");
    if (tiles.levels > 2) bad_image("its tiles have levels of an unknown kind, " + std::to_string(tiles.levels));
    const auto tiles_of = [&](uint64_t width, uint64_t height) {
        return divide_up(width, tiles.width) * divide_up(height, tiles.height);
    };
    const uint64_t levels_x = count_levels(header.width(), tiles.rounds_up),
                   levels_y = count_levels(header.height(), tiles.rounds_up);
    const uint64_t largest = std::max(levels_x, levels_y);
    const bool one = tiles.levels == 0, pyramid = tiles.levels == 1;
    const auto widths = level_sizes(header.width(), one ? 1 : pyramid ? largest : levels_x, tiles.rounds_up);
    const auto heights = level_sizes(header.height(), one ? 1 : pyramid ? largest : levels_y, tiles.rounds_up);
    uint64_t chunks = 0;
    for (size_t x = 0; x < widths.size(); ++x)
        for (size_t y = 0; y < heights.size(); ++y)
            if (!pyramid || x == y) chunks += tiles_of(widths[x], heights[y]);
    return chunks;
}

void judge_offsets(Reader& reader, uint64_t chunks) {
    if (chunks > reader.left() / sizeof(uint64_t))
        bad_image("its table of offsets has " + std::to_string(chunks) + " entries of 8 bytes; the file has " +
                  std::to_string(reader.left()) + " bytes more");
    const uint64_t first_pixels = reader.at() + chunks * sizeof(uint64_t);
    std::array<uint64_t, 4096> offsets;
    for (uint64_t begin = 0; begin < chunks; begin += offsets.size()) {
        const size_t count = static_cast<size_t>(std::min<uint64_t>(offsets.size(), chunks - begin));
        reader.read({reinterpret_cast<char*>(offsets.data()), count * sizeof(uint64_t)});
        for (size_t i = 0; i < count; ++i)
            if (offsets[i] < first_pixels || offsets[i] >= reader.size())
                bad_image("its table of offsets puts pixels " + std::to_string(begin + i) + " at byte " +
                          std::to_string(offsets[i]) + "; the file's pixels are from byte " +
                          std::to_string(first_pixels) + " to " + std::to_string(reader.size()));
    }
}

void judge_exr(Reader& reader) {
    reader.skip(sizeof kExrMagic);
    const auto version = reader.number<uint32_t>();
    if ((version & 0xff) != kExrVersion)
        bad_image("it is OpenEXR of version " + std::to_string(version & 0xff) + ", not " +
                  std::to_string(kExrVersion));
    const size_t most_name = version & kLongNames ? 255 : 31;
    const ExrHeader header = read_exr_header(reader, most_name);
    const bool parted = version & kPartsPossible;
    if (parted && !reader.text(most_name).empty()) bad_image("it has several parts; one is expected");
    if (version & kDeep || header.type.starts_with("deep")) bad_image("deep data is not supported");
    if (!header.data_window) bad_image("its header has no attribute 'dataWindow'");
    if (header.channels == 0) bad_image("it has no channels");
    if (!header.compression || *header.compression >= kRowsOfChunk.size())
        bad_image("its compression is " +
                  (header.compression ? "unknown, " + std::to_string(*header.compression) : "not given"));
    require_image_size(header.width(), header.height(), header.channels);
    judge_offsets(reader, count_chunks(header, parted ? header.type == "tiledimage" : (version & kTiled) != 0));
}

// --- Radiance

void judge_radiance(Reader& reader) {
    constexpr size_t kMostLine = 4096;
    std::string line;
    for (bool in_header = true; in_header;) {
        line.clear();
        while (const char next = reader.number<char>()) {
            if (next == '\n') break;
            line += next;
            if (line.size() > kMostLine || reader.at() > kMaxRadianceHeaderBytes)
                bad_image("its header goes on past byte " + std::to_string(reader.at()));
        }
        in_header = !line.empty();
    }
}

}  // namespace

void require_image_size(uint64_t width, uint64_t height, uint64_t channels) {
    const auto at_most = [](uint64_t count, const char* what, uint64_t limit) {
        if (count > limit)
            bad_image("it has " + std::to_string(count) + " " + what + "; the limit is " + std::to_string(limit));
    };
    if (width == 0 || height == 0 || channels == 0)
        bad_image("its size is " + std::to_string(width) + "x" + std::to_string(height));
    at_most(width, "pixels a row", kMaxImagePixels);  // so that the products below hold
    at_most(height, "rows", kMaxImagePixels);
    at_most(width * height, "pixels", kMaxImagePixels);
    at_most(channels, "channels", kMaxImageChannels);
    at_most(width * height * channels, "values", kMaxImageValues);
}

ImageFileFormat judge_image_file_header(const std::filesystem::path& path) {
    if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(path))) bad_image("it is not a regular file");
    std::array<char, 10> start{};
    std::ifstream(path, std::ios::binary).read(start.data(), start.size());
    Reader reader(path);
    if (std::memcmp(start.data(), &kExrMagic, sizeof kExrMagic) == 0) {
        judge_exr(reader);
        return ImageFileFormat::OpenExr;
    }
    if (std::memcmp(start.data(), "#?RADIANCE", 10) == 0 || std::memcmp(start.data(), "#?RGBE", 6) == 0) {
        judge_radiance(reader);
        return ImageFileFormat::Radiance;
    }
    bad_image("it is neither an OpenEXR nor a Radiance HDR file");
}

}  // namespace photond
