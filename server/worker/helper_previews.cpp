#include "server/worker/helper_previews.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <vector>

#include "protocol/error.h"
#include "renderer/film/film_file.h"
#include "renderer/film/png_file.h"
#include "renderer/film/tone_curve.h"
#include "server/worker/film_layer.h"
#include "server/worker/preview_image.h"

namespace photond {

namespace {

constexpr uint32_t kGap = 4;  // pixels between two pictures of a sheet

ToneCurve curve_named(const std::string& name) {
    const std::optional<ToneCurve> curve = tone_curve_named(name);
    if (!curve) throw Error(ErrorCode::UnknownName, "/curve", "curve \"" + name + "\" is neither srgb nor filmic");
    return *curve;
}

/// What pictures of one size are put into, black before.
class Sheet {
public:
    Sheet(Size2 picture, size_t count, uint32_t columns) : picture_(picture), columns_(columns) {
        const auto rows = static_cast<uint32_t>((count + columns - 1) / columns);
        size_ = {columns * (picture.width + kGap) - kGap, rows * (picture.height + kGap) - kGap};
        rgb_.resize(3 * size_.pixels());
    }

    void put(const PreviewImage& picture, size_t place) {
        const size_t left = place % columns_ * (picture_.width + kGap);
        const size_t top = place / columns_ * (picture_.height + kGap);
        const size_t row_bytes = size_t{3} * picture_.width;
        for (size_t y = 0; y < picture_.height; ++y)
            std::memcpy(&rgb_[3 * ((top + y) * size_.width + left)], &picture.rgb[y * row_bytes], row_bytes);
    }
    void write(const std::filesystem::path& out) const { write_png(size_, rgb_, out); }

private:
    Size2 picture_, size_;
    uint32_t columns_;
    std::vector<uint8_t> rgb_;
};

}  // namespace

void encode_preview(const EncodePreviewRequest& asked, uint64_t memory_bytes) {
    const ToneCurve curve = curve_named(asked.curve);
    const Film film = FilmFile::load(asked.film, memory_bytes).film;
    const LayerInfo* info = nullptr;
    if (asked.layer != "beauty") {
        info = &film_layer(film, asked.layer);
        if (info->preview == LayerPreview::None)
            throw Error(ErrorCode::UnknownName, "/layer", "the layer \"" + asked.layer + "\" has no preview");
    }
    const PreviewImage shown =
        preview_image(film, info, static_cast<float>(asked.exposure), curve, asked.max_size.value_or(UINT32_MAX));
    write_png(shown.size, shown.rgb, asked.out);
}

void encode_sheet(const EncodeSheetRequest& asked, uint64_t memory_bytes) {
    const ToneCurve curve = curve_named(asked.curve);
    const auto columns = static_cast<uint32_t>(std::clamp<size_t>(asked.columns, 1, asked.films.size()));
    std::optional<Sheet> sheet;
    Size2 size;
    for (size_t i = 0; i < asked.films.size(); ++i) {
        const Film film = FilmFile::load(asked.films[i], memory_bytes).film;
        const PreviewImage picture =
            preview_image(film, nullptr, static_cast<float>(asked.exposure), curve, asked.max_size);
        if (!sheet) {
            sheet.emplace(picture.size, asked.films.size(), columns);
            size = film.size();
        }
        if (film.size() != size) throw Error(ErrorCode::Conflict, "the films differ in size");
        sheet->put(picture, i);
    }
    if (sheet) sheet->write(asked.out);
}

}  // namespace photond
