// The part of texture_decode.h that needs OpenImageIO; in the image module (renderer/core/image_module.h).

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <mutex>

#include "protocol/error.h"
#include "renderer/core/huge_pages.h"
#include "renderer/scene/texture_decode.h"

namespace photond {

namespace {

[[noreturn]] void bad(const std::string& detail) { throw Error(ErrorCode::BadImage, "", detail); }

/// An image opened from memory. The library picks its reader by the name's extension, which we derive from the header.
class MemoryImage {
public:
    MemoryImage(std::span<const uint8_t> encoded, const ImageHeader& header)
        : proxy_(const_cast<uint8_t*>(encoded.data()), encoded.size()) {  // the reader takes void*, and only reads
        static std::once_flag once;
        std::call_once(once, [] { OIIO::attribute("threads", 1); });  // the caller decides what runs in parallel
        OIIO::ImageSpec config;
        config["oiio:UnassociatedAlpha"] = 1;
        OIIO::Filesystem::IOProxy* proxy = &proxy_;
        config.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR,
                         &proxy);  // where there is a config, it is read from there
        input_ = OIIO::ImageInput::open(name_of(header.format), &config, &proxy_);
        if (!input_) bad("the image cannot be opened: " + OIIO::geterror());
        const OIIO::ImageSpec& spec = input_->spec();
        if (spec.width != static_cast<int>(header.size.width) || spec.height != static_cast<int>(header.size.height) ||
            spec.depth != 1)
            bad("the image's header contradicts itself");
        if (spec.nchannels < 1 || spec.nchannels > 64)
            bad("the image has " + std::to_string(spec.nchannels) + " channels");
    }

    const OIIO::ImageSpec& spec() const { return input_->spec(); }

    /// Pixels of the channels [first, end), interleaved.
    template <class T>
    std::vector<T> read(OIIO::TypeDesc type, int first, int end) {
        const OIIO::ImageSpec& s = spec();
        std::vector<T> values(size_t(s.width) * size_t(s.height) * size_t(end - first));
        if (!input_->read_image(0, 0, first, end, type, values.data()))
            bad("the image cannot be decoded: " + input_->geterror());
        return values;
    }

private:
    static const char* name_of(ImageFormat format) {
        switch (format) {
            case ImageFormat::Png: return "image.png";
            case ImageFormat::Jpeg: return "image.jpg";
            case ImageFormat::OpenExr: return "image.exr";
            case ImageFormat::RadianceHdr: return "image.hdr";
        }
        return "";
    }

    OIIO::Filesystem::IOMemReader proxy_;
    std::unique_ptr<OIIO::ImageInput> input_;
};

ImageHeader judge_texture(std::span<const uint8_t> encoded, const LoadLimits& limits) {
    const ImageHeader header = read_image_header(encoded);
    if (header.format != ImageFormat::Png && header.format != ImageFormat::Jpeg)
        bad("a texture must be a PNG or a JPEG");
    judge_image_size(header, encoded.size(), sizeof(u8vec4), limits.max_texture_pixels);
    return header;
}

/// The channels to read as r, g, b: [first, first + count), count 1 or 3.
struct ColorChannels {
    int first = 0;
    int count = 3;
};

ColorChannels find_color_channels(const OIIO::ImageSpec& spec) {
    const int r = spec.channelindex("R");
    if (r >= 0 && spec.channelindex("G") == r + 1 && spec.channelindex("B") == r + 2) return {r, 3};
    if (spec.nchannels == 1) return {0, 1};
    if (const int y = spec.channelindex("Y"); y >= 0) return {y, 1};
    bad("the image has no R, G, B channels in one layer");
}

}  // namespace

extern "C" Texture photond_decode_texture(std::span<const uint8_t> encoded, const LoadLimits& limits) {
    const ImageHeader header = judge_texture(encoded, limits);
    MemoryImage image(encoded, header);
    const int channels = std::min(image.spec().nchannels, 4);
    const std::vector<uint8_t> values = image.read<uint8_t>(OIIO::TypeDesc::UINT8, 0, channels);
    Texture texture;
    texture.size = header.size;
    texture.texels.reserve(header.size.pixels());
    prefer_huge_pages(texture.texels.data(), header.size.pixels() * sizeof(u8vec4));
    texture.texels.resize(header.size.pixels());
    for (size_t i = 0; i < texture.texels.size(); ++i) {
        const uint8_t* v = &values[i * static_cast<size_t>(channels)];
        const bool grey = channels < 3;
        texture.texels[i] = u8vec4(v[0], grey ? v[0] : v[1], grey ? v[0] : v[2],
                                   channels == 2   ? v[1]
                                   : channels == 4 ? v[3]
                                                   : uint8_t{255});
    }
    return texture;
}

extern "C" EnvironmentMap photond_decode_environment(std::span<const uint8_t> encoded, const LoadLimits& limits) {
    const ImageHeader header = judge_environment(encoded, limits);
    MemoryImage image(encoded, header);
    const ColorChannels channels = find_color_channels(image.spec());
    const std::vector<float> values =
        image.read<float>(OIIO::TypeDesc::FLOAT, channels.first, channels.first + channels.count);
    EnvironmentMap map;
    map.size = header.size;
    map.radiance.resize(header.size.pixels());
    for (size_t i = 0; i < map.radiance.size(); ++i) {
        const float* v = &values[i * static_cast<size_t>(channels.count)];
        const Rgb radiance = channels.count == 1 ? Rgb(v[0]) : Rgb(v[0], v[1], v[2]);
        if (!is_finite(radiance) || radiance.x < 0 || radiance.y < 0 || radiance.z < 0)
            bad("the radiance at pixel (" + std::to_string(i % map.size.width) + ", " +
                std::to_string(i / map.size.width) + ") is negative or not finite");
        map.radiance[i] = radiance;
    }
    return map;
}

// By these types texture_decode.cpp calls them.
[[maybe_unused]] constexpr decltype(&photond_decode_texture) kDecodeTexture = &decode_texture;
[[maybe_unused]] constexpr decltype(&photond_decode_environment) kDecodeEnvironment = &decode_environment;

}  // namespace photond
