#include "renderer/film/exr_file.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "protocol/error.h"
#include "renderer/core/image_module.h"
#include "renderer/film/image_file_header.h"

namespace photond {

namespace {

static_assert(
    [] {
        uint32_t channels = 3;  // the beauty's
        for (const LayerInfo& info : kLayers) channels += info.channel_count();
        return channels <= kMaxImageChannels;
    }(),
    "an image of every layer must be read again");

std::vector<ImageLayer> resolve_all(const Film& film) {
    std::vector<ImageLayer> all{{channel_names("beauty"), film.resolve_beauty()}};
    for (const LayerInfo& info : kLayers)
        if (film.layers().has(info.layer)) all.push_back({channel_names(info.name), film.resolve(info.layer)});
    return all;
}

/// Of a file whose header has been judged.
LayeredImage read_judged(const std::filesystem::path& path, ImageFileFormat format, uint64_t limit_bytes) {
    static const auto read =
        image_function<LayeredImage(const std::filesystem::path&, ImageFileFormat, uint64_t)>("photond_read_image");
    return read(path, format, limit_bytes);
}

}  // namespace

std::vector<std::string> channel_names(std::string_view layer) {
    if (layer == "beauty") return {"R", "G", "B"};
    const LayerInfo* info = find_layer(layer);
    assert(info);
    std::vector<std::string> names;
    for (const char channel : info->channels) names.push_back(std::string(layer) + "." + channel);
    return names;
}

uint64_t write_exr(Size2 size, std::vector<ImageLayer> layers, Precision precision,
                   std::span<const ImageAttribute> attributes, const std::filesystem::path& path) {
    static const auto write =
        image_function<uint64_t(Size2, std::vector<ImageLayer>, Precision, std::span<const ImageAttribute>,
                                const std::filesystem::path&)>("photond_write_exr");
    return write(size, std::move(layers), precision, attributes, path);
}

uint64_t write_exr(const Film& film, Precision precision, std::span<const ImageAttribute> attributes,
                   const std::filesystem::path& path) {
    return write_exr(film.size(), resolve_all(film), precision, attributes, path);
}

std::vector<uint16_t> to_half(std::span<const float> values, uint64_t& overflowed) {
    static const auto convert = image_function<decltype(to_half)>("photond_to_half");
    return convert(values, overflowed);
}

LayeredImage read_exr(const std::filesystem::path& path) {
    if (judge_image_file_header(path) != ImageFileFormat::OpenExr)
        throw Error(ErrorCode::BadImage, "it is not an OpenEXR file");
    return read_judged(path, ImageFileFormat::OpenExr, UINT64_MAX);
}

LayeredImage read_image(const std::filesystem::path& path, uint64_t limit_bytes) {
    return read_judged(path, judge_image_file_header(path), limit_bytes);
}

ReadLayer read_image_layer(const std::filesystem::path& path, const std::string& layer, uint64_t limit_bytes) {
    static const auto read =
        image_function<ReadLayer(const std::filesystem::path&, ImageFileFormat, const std::string&, uint64_t)>(
            "photond_read_image_layer");
    return read(path, judge_image_file_header(path), layer, limit_bytes);
}

JudgedImage judge_image(const std::filesystem::path& path) {
    static const auto judge =
        image_function<JudgedImage(const std::filesystem::path&, ImageFileFormat)>("photond_judge_image");
    return judge(path, judge_image_file_header(path));
}

void warm_up_exr() { image_function<decltype(warm_up_exr)>("photond_warm_up_exr")(); }

}  // namespace photond
