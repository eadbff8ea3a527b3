#include "server/worker/raw_pixels.h"

#include <algorithm>
#include <bit>

#include "protocol/error.h"
#include "renderer/core/atomic_file.h"
#include "renderer/film/film_file.h"
#include "server/worker/film_layer.h"

namespace photond {

namespace {

static_assert(std::endian::native == std::endian::little, "pixels are written as they lie in memory");

constexpr size_t kHalvesAtOnce = 1 << 20;  // so that no second copy of a large image is held

ReadLayer layer_of_film(const Film& film, const std::string& name) {
    if (name == "beauty") return {film.size(), 3, film.resolve_beauty()};
    const LayerInfo& info = film_layer(film, name);
    return {film.size(), info.channel_count(), film.resolve(info.layer)};
}

}  // namespace

Precision precision_named(const std::string& name) {
    if (name == "float") return Precision::Float;
    if (name == "half") return Precision::Half;
    throw Error(ErrorCode::UnknownName, "/precision", "precision \"" + name + "\" is neither float nor half");
}

EncodedReply write_raw_pixels(Size2 size, uint32_t channels, std::span<const float> pixels, Precision precision,
                              const std::filesystem::path& path) {
    uint64_t overflowed = 0;
    AtomicFile out(path);
    if (precision == Precision::Half) {
        for (size_t first = 0; first < pixels.size(); first += kHalvesAtOnce) {
            const std::vector<uint16_t> halves =
                to_half(pixels.subspan(first, std::min(kHalvesAtOnce, pixels.size() - first)), overflowed);
            out.write(halves.data(), halves.size() * sizeof(uint16_t));
        }
    } else {
        out.write(pixels.data(), pixels.size_bytes());
    }
    out.commit();
    return {size.width, size.height, channels, overflowed, std::nullopt};
}

EncodedReply encode_pixels(const EncodePixelsRequest& asked, uint64_t memory_bytes) {
    const Precision precision = precision_named(asked.precision);
    const ImageSource& source = asked.source;
    if (!source.image && !source.film) throw Error(ErrorCode::MissingField, "/film", "or an image must be named");
    const ReadLayer layer = source.image ? read_image_layer(*source.image, asked.layer, memory_bytes)
                                         : layer_of_film(FilmFile::load(*source.film, memory_bytes).film, asked.layer);
    return write_raw_pixels(layer.size, layer.channels, layer.pixels, precision, asked.out);
}

}  // namespace photond
