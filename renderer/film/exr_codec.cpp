// The part of exr_file.h that needs OpenImageIO; in the image module (renderer/core/image_module.h).

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/half.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "protocol/error.h"
#include "renderer/core/atomic_file.h"
#include "renderer/core/parallel.h"
#include "renderer/film/exr_file.h"

namespace photond {

namespace {

constexpr size_t kRowsAtOnce = 256;  // a multiple of ZIP's 16 rows, enough for the library's threads

/// CIE xy of red, green, blue and white (D65): ITU-R BT.709.
constexpr float kRec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

/// Infinity in place of what half cannot hold; returns how many values that were.
uint64_t overflow_to_infinity(std::span<float> values) {
    uint64_t overflowed = 0;
    for (float& value : values)
        if (std::fabs(value) > kLargestHalf && !std::isinf(value))
            value = std::copysign(kInfinity, value), ++overflowed;
    return overflowed;
}

/// The library reports errors as text; a full disk has to be told from a defect.
[[noreturn]] void fail_writing(const OIIO::ImageOutput& output, AtomicFile& file) {
    const std::string reason = output.geterror();
    file.commit();  // throws NoSpace when that was the reason
    throw Error(ErrorCode::Internal, "cannot encode the EXR: " + reason);
}

std::unique_ptr<OIIO::ImageOutput> exr_output() {
    std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("exr");
    if (!output) throw Error(ErrorCode::Internal, "the image library cannot write EXR: " + OIIO::geterror());
    return output;
}

void encode(OIIO::Filesystem::IOProxy& proxy, AtomicFile* file, Size2 size, std::span<const ImageLayer> layers,
            Precision precision, std::span<const ImageAttribute> attributes) {
    OIIO::ImageSpec spec(static_cast<int>(size.width), static_cast<int>(size.height), 0,
                         precision == Precision::Half ? OIIO::TypeHalf : OIIO::TypeFloat);
    for (const ImageLayer& layer : layers)
        spec.channelnames.insert(spec.channelnames.end(), layer.channel_names.begin(), layer.channel_names.end());
    spec.nchannels = static_cast<int>(spec.channelnames.size());
    spec.alpha_channel = spec.z_channel = -1;
    spec.attribute("compression", "zip");
    // The library writes today's date unless there is one; one of the wrong type it leaves out, with a debug message.
    OIIO::attribute("debug", 0);
    spec.attribute("DateTime", 0);
    spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), kRec709);
    spec.attribute("oiio:ColorSpace", "Linear");
    for (const ImageAttribute& attribute : attributes) {
        if (const double* number = std::get_if<double>(&attribute.value))
            spec.attribute(attribute.name, OIIO::TypeDesc::DOUBLE, number);
        else
            spec.attribute(attribute.name, std::get<std::string>(attribute.value));
    }
    const std::unique_ptr<OIIO::ImageOutput> output = exr_output();
    const auto fail = [&] {
        if (file) fail_writing(*output, *file);
        throw Error(ErrorCode::Internal, "cannot encode the EXR: " + output->geterror());
    };
    if (!output->set_ioproxy(&proxy) || !output->open("image.exr", spec)) fail();

    const size_t channels = static_cast<size_t>(spec.nchannels);
    std::vector<float> rows(std::min<size_t>(kRowsAtOnce, size.height) * size.width * channels);
    for (size_t first = 0; first < size.height; first += kRowsAtOnce) {
        const size_t count = std::min<size_t>(kRowsAtOnce, size.height - first);
        parallel_for(count, 8, [&](size_t row) {
            size_t channel = 0;
            for (const ImageLayer& layer : layers) {
                const size_t n = layer.channel_names.size();
                const float* in = layer.pixels.data() + (first + row) * size.width * n;
                float* out = rows.data() + row * size.width * channels + channel;
                for (size_t x = 0; x < size.width; ++x, in += n, out += channels)
                    for (size_t k = 0; k < n; ++k) out[k] = in[k];
                channel += n;
            }
        });
        if (!output->write_scanlines(static_cast<int>(first), static_cast<int>(first + count), 0, OIIO::TypeFloat,
                                     rows.data()))
            fail();
    }
    if (!output->close()) fail();
}

[[noreturn]] void bad_image(const std::string& why) { throw Error(ErrorCode::BadImage, why); }

/// What the library says, without the names of files: where an upload lies is nobody's business but ours.
std::string without_paths(std::string reason) {
    for (size_t at = reason.find(" \"/"); at != std::string::npos; at = reason.find(" \"/", at)) {
        const size_t end = reason.find('"', at + 2);
        reason.erase(at, end == std::string::npos ? end : end + 1 - at);
    }
    return reason;
}

/// Opens an image whose header has been judged, and judges what the library makes of it. No pixels have been read.
std::unique_ptr<OIIO::ImageInput> open_judged(const std::filesystem::path& path, ImageFileFormat format) {
    // By its content: names are not looked at.
    std::unique_ptr<OIIO::ImageInput> input =
        OIIO::ImageInput::create(format == ImageFileFormat::OpenExr ? "openexr" : "hdr");
    OIIO::ImageSpec spec;
    if (!input || !input->open(path.string(), spec))
        bad_image("its header cannot be read: " + without_paths(input ? input->geterror() : OIIO::geterror()));
    if (spec.width <= 0 || spec.height <= 0 || spec.depth > 1 || spec.nchannels <= 0)
        bad_image("its size is " + std::to_string(spec.width) + "x" + std::to_string(spec.height));
    require_image_size(static_cast<uint64_t>(spec.width), static_cast<uint64_t>(spec.height),
                       static_cast<uint64_t>(spec.nchannels));
    // The library leaves a Radiance image as it is stored.
    if (format == ImageFileFormat::Radiance && spec.get_int_attribute("Orientation", 1) != 1)
        bad_image("its pixels are not stored from the top left, row by row");
    return input;
}

/// Reads all channels of every row, a band at a time, and hands each band to `take(first_row, rows)`.
template <class Take>
void read_rows(OIIO::ImageInput& input, const Take& take) {
    const OIIO::ImageSpec spec = input.spec();
    const bool tiled = spec.tile_width > 0;
    const int rows_at_once = std::min(spec.height, tiled ? spec.tile_height : static_cast<int>(kRowsAtOnce));
    const size_t row_values = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.nchannels);
    std::vector<float> band(row_values * static_cast<size_t>(rows_at_once));
    for (int y = 0; y < spec.height; y += rows_at_once) {
        const int last = std::min(spec.height, y + rows_at_once);
        const bool decoded = tiled ? input.read_tiles(0, 0, spec.x, spec.x + spec.width, spec.y + y, spec.y + last, 0,
                                                      1, 0, spec.nchannels, OIIO::TypeFloat, band.data())
                                   : input.read_scanlines(0, 0, spec.y + y, spec.y + last, 0, 0, spec.nchannels,
                                                          OIIO::TypeFloat, band.data());
        if (!decoded) bad_image("its pixels cannot be decoded: " + without_paths(input.geterror()));
        take(static_cast<size_t>(y), std::span<const float>(band).first(row_values * static_cast<size_t>(last - y)));
    }
}

Size2 size_of(const OIIO::ImageSpec& spec) {
    return {static_cast<uint32_t>(spec.width), static_cast<uint32_t>(spec.height)};
}

/// The pixels of some of the image's layers, in their order.
std::vector<std::vector<float>> read_pixels(OIIO::ImageInput& input, std::span<const NamedLayer> layers,
                                            uint64_t limit_bytes) {
    const OIIO::ImageSpec spec = input.spec();
    const Size2 size = size_of(spec);
    uint64_t bytes = 0;
    for (const NamedLayer& layer : layers) bytes += size.pixels() * layer.channels.size() * sizeof(float);
    if (bytes > limit_bytes)
        throw Error(ErrorCode::OutOfMemory, "the image takes " + std::to_string(bytes) + " bytes; the limit is " +
                                                std::to_string(limit_bytes) + " bytes");
    std::vector<std::vector<float>> pixels;
    for (const NamedLayer& layer : layers) pixels.emplace_back(size.pixels() * layer.channels.size());
    const size_t channel_count = static_cast<size_t>(spec.nchannels);
    read_rows(input, [&](size_t first_row, std::span<const float> rows) {
        for (size_t i = 0; i < layers.size(); ++i) {
            const std::vector<size_t>& channels = layers[i].channels;
            float* out = pixels[i].data() + first_row * size.width * channels.size();
            for (size_t pixel = 0; pixel < rows.size() / channel_count; ++pixel)
                for (const size_t channel : channels) *out++ = rows[pixel * channel_count + channel];
        }
    });
    return pixels;
}

/// Whether the layer is one of ours: the beauty, or one of kLayers with the channels of its row there.
bool is_known(const NamedLayer& layer, std::span<const std::string> names) {
    const bool listed = layer.name == "beauty" || std::any_of(kLayers.begin(), kLayers.end(),
                                                              [&](const LayerInfo& l) { return l.name == layer.name; });
    if (!listed) return false;
    const std::vector<std::string> expected = channel_names(layer.name);
    return std::equal(layer.channels.begin(), layer.channels.end(), expected.begin(), expected.end(),
                      [&](size_t channel, const std::string& name) { return names[channel] == name; });
}

/// The beauty and every layer that is_known().
LayeredImage read_layers(OIIO::ImageInput& input, uint64_t limit_bytes) {
    const OIIO::ImageSpec spec = input.spec();
    std::vector<NamedLayer> layers = layers_of_channels(spec.channelnames);
    std::erase_if(layers, [&](const NamedLayer& layer) { return !is_known(layer, spec.channelnames); });
    if (layers.empty() || layers.front().name != "beauty") bad_image("it has no channels R, G and B");
    std::vector<std::vector<float>> pixels = read_pixels(input, layers, limit_bytes);
    LayeredImage image{size_of(spec), {}};
    for (size_t i = 0; i < layers.size(); ++i) image.layers[layers[i].name] = std::move(pixels[i]);
    return image;
}

}  // namespace

extern "C" {

uint64_t photond_write_exr(Size2 size, std::vector<ImageLayer> layers, Precision precision,
                           std::span<const ImageAttribute> attributes, const std::filesystem::path& path) {
    uint64_t overflowed = 0;
    if (precision == Precision::Half)
        for (ImageLayer& layer : layers) overflowed += overflow_to_infinity(layer.pixels);
    AtomicFile file(path);
    {
        OIIO::Filesystem::IOFile proxy(file.stream(), OIIO::Filesystem::IOProxy::Write);
        encode(proxy, &file, size, layers, precision, attributes);
    }
    file.commit();
    return overflowed;
}

std::vector<uint16_t> photond_to_half(std::span<const float> values, uint64_t& overflowed) {
    std::vector<float> bounded(values.begin(), values.end());
    overflowed += overflow_to_infinity(bounded);
    std::vector<uint16_t> halves(values.size());
    for (size_t i = 0; i < values.size(); ++i) halves[i] = half(bounded[i]).bits();
    return halves;
}

LayeredImage photond_read_image(const std::filesystem::path& path, ImageFileFormat format, uint64_t limit_bytes) {
    return read_layers(*open_judged(path, format), limit_bytes);
}

ReadLayer photond_read_image_layer(const std::filesystem::path& path, ImageFileFormat format, const std::string& layer,
                                   uint64_t limit_bytes) {
    const std::unique_ptr<OIIO::ImageInput> input = open_judged(path, format);
    const OIIO::ImageSpec spec = input->spec();
    const std::vector<NamedLayer> layers = layers_of_channels(spec.channelnames);
    const auto found = std::find_if(layers.begin(), layers.end(), [&](const NamedLayer& l) { return l.name == layer; });
    if (found == layers.end()) {
        std::string there;
        for (const NamedLayer& other : layers) there += (there.empty() ? "it has " : ", ") + other.name;
        throw Error(ErrorCode::UnknownName, "/layer",
                    "the image has no layer \"" + layer + "\"" + (there.empty() ? "" : "; " + there));
    }
    std::vector<std::vector<float>> pixels = read_pixels(*input, {&*found, 1}, limit_bytes);
    return {size_of(spec), static_cast<uint32_t>(found->channels.size()), std::move(pixels.front())};
}

JudgedImage photond_judge_image(const std::filesystem::path& path, ImageFileFormat format) {
    const std::unique_ptr<OIIO::ImageInput> input = open_judged(path, format);
    const OIIO::ImageSpec spec = input->spec();
    read_rows(*input, [](size_t, std::span<const float>) {});
    return {size_of(spec), static_cast<uint32_t>(spec.nchannels), layers_of_channels(spec.channelnames)};
}

void photond_warm_up_exr() {
    const Size2 size{64, 64};
    const std::vector<ImageLayer> layers{{{"R", "G", "B"}, std::vector<float>(3 * size.pixels(), 0.5f)}};
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    encode(memory, nullptr, size, layers, Precision::Half, {});
}

}  // extern "C"

// By these types exr_file.cpp calls them.
[[maybe_unused]] constexpr decltype(&photond_write_exr) kWriteExr = &write_exr;
[[maybe_unused]] constexpr decltype(&photond_to_half) kToHalf = &to_half;
[[maybe_unused]] constexpr decltype(&photond_warm_up_exr) kWarmUpExr = &warm_up_exr;

}  // namespace photond
