#include "renderer/film/film_file.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <span>

#include "protocol/error.h"
#include "renderer/core/checked_file.h"
#include "renderer/core/copy_elements.h"
#include "renderer/core/parallel.h"
#include "renderer/core/sha256.h"

namespace photond {

namespace {

constexpr char kMagic[8] = {'P', 'H', 'O', 'T', 'F', 'I', 'L', 'M'};
constexpr uint32_t kVersion = 9;
constexpr uint32_t kOldestVersion = 1;
constexpr uint32_t kVersionOfIdentity = 3;    // identity, history and ranges follow the header
constexpr uint32_t kVersionOfOrigin = 5;      // and then the origin
constexpr uint32_t kVersionOfMeans = 6;       // and then what passes say of the image's mean
constexpr uint32_t kVersionOfState = 7;       // and then the method's state
constexpr uint32_t kVersionOfMoreLayers = 8;  // than 32: written only where there are any of those
constexpr uint32_t kVersionOfLeft = 9;        // what is left to the next frame follows the state, where there is any
constexpr size_t kLayersOfVersion1 = 9;       // all up to standard_error
constexpr size_t kLayersOfVersion3 = 11;      // all up to overlap
constexpr uint32_t kVersionOfAllLayers = 4;
constexpr size_t kBlockValues = 1 << 12;  // sums a block: 64 KiB at most, which malloc takes from memory it has
constexpr size_t kBlocksAtOnce = 64;      // encoded side by side before they are written in order
constexpr size_t kDigestBytes = 32;       // as hexadecimal digits
constexpr uint32_t kMaxSide = 1u << 20;
constexpr uint64_t kMaxTextBytes = 64ull << 20;
constexpr uint64_t kMaxRanges = 1u << 20;
constexpr size_t kStatePieceBytes = 1 << 20;

struct Header {
    char magic[8];
    uint32_t version;
    uint32_t width;
    uint32_t height;
    uint32_t layers;  // bit i: kLayers[i]
    uint32_t passes;
    uint32_t more_layers;  // bit i: kLayers[32 + i]; 0 in older versions
    uint64_t nan_count;
    uint64_t infinity_count;
    char digest[kDigestBytes];  // of all that comes before it
};
static_assert(sizeof(Header) == 80 && std::endian::native == std::endian::little, "written as it lies in memory");

std::string digest_of(const void* data, size_t bytes) { return sha256_hex(data, bytes).substr(0, kDigestBytes); }

/// Bytes that keep `value` in two's complement (signed) or as it is (unsigned).
uint32_t width_of(FixedSum value) {
    const FixedSquares magnitude = static_cast<FixedSquares>(value < 0 ? ~value : value);
    uint32_t bytes = 1;
    while (bytes < 16 && (magnitude >> (8 * bytes - 1)) != 0) ++bytes;
    return bytes;
}
uint32_t width_of(FixedSquares value) {
    uint32_t bytes = 1;
    while (bytes < 16 && (value >> (8 * bytes)) != 0) ++bytes;
    return bytes;
}
uint32_t width_of(uint32_t) { return sizeof(uint32_t); }

/// One byte: the width; the values; the digest.
template <class Value>
std::string encode_block(std::span<const Value> values) {
    // The widest value has the highest bit of any: take the union of magnitudes first, which costs one pass.
    Value all = 0;
    for (const Value value : values) {
        if constexpr (std::is_same_v<Value, FixedSum>)
            all |= value < 0 ? ~value : value;
        else
            all |= value;
    }
    const uint32_t width = width_of(all);
    std::string block(1 + values.size() * width + kDigestBytes + 16, '\0');
    char* out = block.data();
    *out++ = static_cast<char>(width);
    for (const Value& value : values) {
        std::memcpy(out, &value, sizeof value);  // what is past `width` is overwritten by the next
        out += width;
    }
    const size_t bytes = static_cast<size_t>(out - block.data());
    const std::string digest = digest_of(block.data(), bytes);
    std::memcpy(out, digest.data(), kDigestBytes);
    block.resize(bytes + kDigestBytes);
    return block;
}

[[noreturn]] void damaged(const std::filesystem::path& path, const std::string& what) {
    throw Error(ErrorCode::ResultDamaged, "the film file " + path.filename().string() + " is damaged: " + what);
}

class Reader {
public:
    static constexpr size_t kBufferBytes = 1 << 20;  // a call of the system for each 4 kB took longer than the copying

    explicit Reader(const std::filesystem::path& path)
        : path_(path), file_(std::fopen(path.c_str(), "rb"), &std::fclose) {
        if (!file_)
            throw Error(errno == ENOENT ? ErrorCode::ResultLost : ErrorCode::Internal,
                        "the film file " + path.filename().string() + " cannot be opened: " + std::strerror(errno));
        std::setvbuf(file_.get(), nullptr, _IOFBF, kBufferBytes);
    }
    void read(void* data, size_t bytes) {
        if (std::fread(data, 1, bytes, file_.get()) != bytes) damaged(path_, "it is cut short");
    }
    template <class Value>
    void read_block(std::span<Value> values) {
        uint8_t width = 0;
        read(&width, 1);
        if (width == 0 || width > sizeof(Value)) damaged(path_, "sums of " + std::to_string(width) + " bytes");
        buffer_.resize(1 + values.size() * width + kDigestBytes);
        buffer_[0] = static_cast<char>(width);
        read(buffer_.data() + 1, buffer_.size() - 1);
        const size_t bytes = buffer_.size() - kDigestBytes;
        if (std::memcmp(digest_of(buffer_.data(), bytes).data(), buffer_.data() + bytes, kDigestBytes) != 0)
            damaged(path_, "a block does not match its checksum");
        const char* in = buffer_.data() + 1;
        constexpr unsigned kBits = 8 * sizeof(Value);
        const unsigned unused = kBits - 8u * width;
        for (Value& value : values) {
            Value raw;
            static_assert(sizeof raw <= kDigestBytes, "the digest lies behind the last value: reading past it is safe");
            std::memcpy(&raw, in, sizeof raw);
            value = static_cast<Value>(raw << unused) >> unused;  // extends the sign of signed sums
            in += width;
        }
    }
    void expect_end() {
        if (std::fgetc(file_.get()) != EOF) damaged(path_, "it is too long");
    }

private:
    const std::filesystem::path path_;
    std::unique_ptr<FILE, int (*)(FILE*)> file_;
    std::string buffer_;
};

}  // namespace

namespace {

/// The length, the bytes, the digest of both.
std::string encode_text(const void* data, uint64_t bytes) {
    std::string block(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    block.append(static_cast<const char*>(data), bytes);
    return block + digest_of(block.data(), block.size());
}
std::string encode_text(const std::string& text) { return encode_text(text.data(), text.size()); }

std::string read_text(Reader& reader, const std::filesystem::path& path, uint64_t limit) {
    uint64_t bytes = 0;
    reader.read(&bytes, sizeof bytes);
    if (bytes > limit) damaged(path, "a part of " + std::to_string(bytes) + " bytes");
    std::string block(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    block.resize(sizeof bytes + bytes);
    reader.read(block.data() + sizeof bytes, bytes);
    char digest[kDigestBytes];
    reader.read(digest, sizeof digest);
    if (std::memcmp(digest_of(block.data(), block.size()).data(), digest, kDigestBytes) != 0)
        damaged(path, "a part does not match its checksum");
    return block.substr(sizeof bytes);
}

/// The length of what may be long, then pieces of it.
void write_pieces(CheckedFile& file, const std::string& whole) {
    const uint64_t bytes = whole.size();
    const std::string length = encode_text(&bytes, sizeof bytes);
    file.write(length.data(), length.size());
    for (size_t first = 0; first < whole.size(); first += kStatePieceBytes) {
        const std::string piece =
            encode_text(whole.data() + first, std::min<uint64_t>(kStatePieceBytes, whole.size() - first));
        file.write(piece.data(), piece.size());
    }
}

/// What write_pieces() wrote; `take` is called for each piece.
template <class Take>
void read_pieces(Reader& reader, const std::filesystem::path& path, uint64_t limit_bytes, const Take& take) {
    const std::string length = read_text(reader, path, sizeof(uint64_t));
    uint64_t bytes = 0;
    if (length.size() != sizeof bytes) damaged(path, "it does not say how long a part is");
    std::memcpy(&bytes, length.data(), sizeof bytes);
    if (bytes > limit_bytes)
        throw Error(ErrorCode::OutOfMemory, "a part of the film takes " + std::to_string(bytes) +
                                                " bytes; the limit is " + std::to_string(limit_bytes) + " bytes");
    while (bytes > 0) {
        const std::string piece = read_text(reader, path, kStatePieceBytes);
        if (piece.size() != std::min<uint64_t>(bytes, kStatePieceBytes)) damaged(path, "a part of it is not whole");
        bytes -= piece.size();
        take(piece);
    }
}

PassRanges read_ranges(Reader& reader, const std::filesystem::path& path) {
    const std::string bytes = read_text(reader, path, kMaxRanges * sizeof(PassRanges::Range));
    if (bytes.size() % sizeof(PassRanges::Range) != 0) damaged(path, "its ranges are not whole");
    std::vector<PassRanges::Range> ranges(bytes.size() / sizeof(PassRanges::Range));
    copy_elements(bytes.data(), std::span(ranges));
    try {
        return PassRanges(std::move(ranges));
    } catch (const Error& error) {
        damaged(path, error.what());
    }
}

size_t known_layers_of(uint32_t version) {
    return version == 1 ? kLayersOfVersion1 : version < kVersionOfAllLayers ? kLayersOfVersion3 : kLayerCount;
}

/// Bit i: kLayers[i].
uint64_t layer_bits(const Header& header) { return uint64_t{header.more_layers} << 32 | header.layers; }

LayerSet layers_of(const Header& header) {
    LayerSet layers;
    for (const LayerInfo& info : kLayers)
        if (layer_bits(header) >> static_cast<unsigned>(info.layer) & 1u) layers.add(info.layer);
    return layers;
}

Header read_header(Reader& reader, const std::filesystem::path& path) {
    Header header{};
    reader.read(&header, sizeof header);
    if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0) damaged(path, "it is not a film");
    if (std::memcmp(header.digest, digest_of(&header, offsetof(Header, digest)).data(), kDigestBytes) != 0)
        damaged(path, "its header does not match its checksum");
    if (header.version < kOldestVersion || header.version > kVersion)
        throw Error(ErrorCode::Unsupported, "the film file " + path.filename().string() + " has version " +
                                                std::to_string(header.version) + "; this program reads " +
                                                std::to_string(kOldestVersion) + " to " + std::to_string(kVersion));
    const size_t known_layers = known_layers_of(header.version);
    if (header.version >= kVersionOfAllLayers && layer_bits(header) >> known_layers != 0)
        throw Error(ErrorCode::Unsupported, "the film file " + path.filename().string() +
                                                " has layers that this program does not know: a newer one wrote it");
    if (header.width > kMaxSide || header.height > kMaxSide || layer_bits(header) >> known_layers != 0)
        damaged(path, "its size or layers are out of range");
    return header;
}

/// What lies between header and sums.
struct Texts {
    FilmIdentity identity;
    std::string history, origin;
    PassRanges ranges;
    PassMeans means;  // of no pass where the version did not keep them
};

Texts read_texts(Reader& reader, const std::filesystem::path& path, const Header& header) {
    Texts texts;
    if (header.version < kVersionOfIdentity) {
        if (header.passes > 0) texts.ranges = PassRanges({{0, header.passes}});
        return texts;
    }
    texts.identity.scene = read_text(reader, path, kMaxTextBytes);
    texts.identity.settings = read_text(reader, path, kMaxTextBytes);
    texts.identity.device = read_text(reader, path, kMaxTextBytes);
    texts.history = read_text(reader, path, kMaxTextBytes);
    texts.ranges = read_ranges(reader, path);
    if (texts.ranges.count() != header.passes) damaged(path, "its ranges are not of its passes");
    if (header.version >= kVersionOfOrigin) texts.origin = read_text(reader, path, kMaxTextBytes);
    if (header.version >= kVersionOfMeans) {
        const std::optional<PassMeans> means = PassMeans::from_bytes(read_text(reader, path, kMaxTextBytes));
        if (!means || means->passes() > header.passes) damaged(path, "its means are not of its passes");
        texts.means = *means;
    }
    return texts;
}

}  // namespace

template <class FilmType, class Visitor>
void FilmFile::for_each_array(FilmType& film, const Visitor& visitor) {
    for (auto& sums : film.sums_) visitor(sums);
    visitor(film.squares_beauty_), visitor(film.squares_direct_), visitor(film.squares_indirect_);
    visitor(film.hits_);
}

void FilmFile::save(const Film& film, const FilmIdentity& identity, const std::string& history,
                    const std::filesystem::path& path, const std::string& origin, const std::string& state,
                    const std::string& left) {
    CheckedFile file(path);
    Header header{};
    std::memcpy(header.magic, kMagic, sizeof kMagic);
    header.width = film.size_.width, header.height = film.size_.height;
    for (const LayerInfo& info : kLayers) {
        const auto bit = static_cast<unsigned>(info.layer);
        if (film.layers_.has(info.layer)) (bit < 32 ? header.layers : header.more_layers) |= 1u << bit % 32;
    }
    header.version = !left.empty()             ? kVersionOfLeft
                     : header.more_layers != 0 ? kVersionOfMoreLayers
                                               : kVersionOfMoreLayers - 1;
    header.passes = film.passes_, header.nan_count = film.nan_count_, header.infinity_count = film.infinity_count_;
    std::memcpy(header.digest, digest_of(&header, offsetof(Header, digest)).data(), kDigestBytes);
    file.write(&header, sizeof header);
    const std::vector<PassRanges::Range>& ranges = film.pass_ranges_.ranges();
    for (const std::string& part :
         {encode_text(identity.scene), encode_text(identity.settings), encode_text(identity.device),
          encode_text(history), encode_text(ranges.data(), ranges.size() * sizeof(PassRanges::Range)),
          encode_text(origin), encode_text(film.pass_means_.bytes())})
        file.write(part.data(), part.size());
    write_pieces(file, state);
    if (header.version >= kVersionOfLeft) write_pieces(file, left);

    for_each_array(film, [&](const auto& values) {
        const size_t blocks = (values.size() + kBlockValues - 1) / kBlockValues;
        for (size_t first = 0; first < blocks; first += kBlocksAtOnce) {
            std::vector<std::string> encoded(std::min(kBlocksAtOnce, blocks - first));
            parallel_for(encoded.size(), 1, [&](size_t i) {
                const size_t start = (first + i) * kBlockValues;
                encoded[i] =
                    encode_block(std::span(values).subspan(start, std::min(kBlockValues, values.size() - start)));
            });
            for (const std::string& block : encoded) file.write(block.data(), block.size());
        }
    });
    file.commit();
}

SavedFilm FilmFile::load(const std::filesystem::path& path, uint64_t limit_bytes) {
    Reader reader(path);
    const Header header = read_header(reader, path);
    const Size2 size{header.width, header.height};
    const LayerSet layers = layers_of(header);
    const uint64_t bytes = Film::bytes_for(size, layers);
    if (bytes > limit_bytes)
        throw Error(ErrorCode::OutOfMemory, "the film takes " + std::to_string(bytes) + " bytes; the limit is " +
                                                std::to_string(limit_bytes) + " bytes");
    SavedFilm saved{Film(size, layers), {}, {}, {}, {}};
    Film& film = saved.film;
    Texts texts = read_texts(reader, path, header);
    saved.identity = std::move(texts.identity);
    saved.history = std::move(texts.history);
    if (header.version >= kVersionOfState)
        read_pieces(reader, path, limit_bytes - bytes, [&](const std::string& piece) { saved.state += piece; });
    if (header.version >= kVersionOfLeft)
        read_pieces(reader, path, limit_bytes - bytes - saved.state.size(),
                    [&](const std::string& piece) { saved.left += piece; });
    film.pass_ranges_ = std::move(texts.ranges);
    film.pass_means_ = texts.means;
    film.next_pass_ = film.pass_ranges_.end();
    film.passes_ = header.passes, film.nan_count_ = header.nan_count, film.infinity_count_ = header.infinity_count;
    for_each_array(film, [&](auto& values) {
        for (size_t start = 0; start < values.size(); start += kBlockValues)
            reader.read_block(std::span(values).subspan(start, std::min(kBlockValues, values.size() - start)));
    });
    reader.expect_end();
    return saved;
}

std::string FilmFile::load_left(const std::filesystem::path& path, const FilmIdentity& identity, uint64_t limit_bytes) {
    Reader reader(path);
    const Header header = read_header(reader, path);
    FilmIdentity found = read_texts(reader, path, header).identity;
    found.settings = identity.settings;  // each frame has its own
    require_alike(found, identity);
    std::string left;
    if (header.version < kVersionOfLeft) return left;
    read_pieces(reader, path, limit_bytes, [](const std::string&) {});
    read_pieces(reader, path, limit_bytes, [&](const std::string& piece) { left += piece; });
    return left;
}

FilmFacts FilmFile::examine(const std::filesystem::path& path) {
    Reader reader(path);
    const Header header = read_header(reader, path);
    Texts texts = read_texts(reader, path, header);
    for (const uint32_t since : {kVersionOfState, kVersionOfLeft})
        if (header.version >= since) read_pieces(reader, path, UINT64_MAX, [](const std::string&) {});
    Film pixel({1, 1}, layers_of(header));  // as many sums an array as a film has for each of its pixels
    const size_t pixels = size_t{header.width} * header.height;
    for_each_array(pixel, [&](auto& values) {
        using Value = typename std::decay_t<decltype(values)>::value_type;
        const size_t count = values.size() * pixels;
        std::vector<Value> block(std::min(kBlockValues, count));
        for (size_t start = 0; start < count; start += kBlockValues)
            reader.read_block(std::span(block).first(std::min(kBlockValues, count - start)));
    });
    reader.expect_end();
    return {header.passes, std::move(texts.history), std::move(texts.origin)};
}

void require_alike(const FilmIdentity& a, const FilmIdentity& b) {
    if (a == FilmIdentity() || b == FilmIdentity())
        throw Error(ErrorCode::Conflict, "a film of an older version, which does not say what it shows");
    constexpr size_t kHashShown = 24;     // enough of a hash to tell two apart
    constexpr size_t kDeviceShown = 200;  // names what of the processor and the program differs
    const auto differ = [](const char* what, const std::string& x, const std::string& y, size_t shown) {
        if (x != y)
            throw Error(ErrorCode::Conflict, std::string("films of different ") + what + ": " + x.substr(0, shown) +
                                                 " and " + y.substr(0, shown));
    };
    differ("scenes", a.scene, b.scene, kHashShown);
    differ("settings", a.settings, b.settings, kHashShown);
    differ("devices or versions", a.device, b.device, kDeviceShown);
}

}  // namespace photond
