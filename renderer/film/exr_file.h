#pragma once
// OpenEXR in and out (protocol.md, "The EXR"). Beside it only png_file.h and scene/texture_codec.cpp know an image
// library.

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "renderer/film/film.h"
#include "renderer/film/image_file_header.h"
#include "renderer/film/image_layers.h"

namespace photond {

enum class Precision : uint8_t { Float, Half };

/// Largest finite half; larger values are stored as infinity and counted.
inline constexpr float kLargestHalf = 65504.0f;

/// One attribute of the header, its full name included ("photond:seed").
struct ImageAttribute {
    std::string name;
    std::variant<double, std::string> value;
};

/// One layer as written: its channels' full names ("R", "indirect.G") and its pixels, interleaved, row 0 at the top.
struct ImageLayer {
    std::vector<std::string> channel_names;
    std::vector<float> pixels;
};

/// The channels' names in an image, for "beauty" and the layers of kLayers (protocol.md, "The EXR").
std::vector<std::string> channel_names(std::string_view layer);

/// Writes the layers, each of size.pixels() times its channels: one part, scanlines, ZIP, Rec.709 chromaticities, no
/// date; the same film and attributes give the same bytes. Returns how many finite values became infinite. Throws
/// ErrorCode::NoSpace.
uint64_t write_exr(Size2 size, std::vector<ImageLayer> layers, Precision precision,
                   std::span<const ImageAttribute> attributes, const std::filesystem::path& path);
/// Every layer of the film, the beauty first.
uint64_t write_exr(const Film& film, Precision precision, std::span<const ImageAttribute> attributes,
                   const std::filesystem::path& path);

/// Rounds to half precision, row by row as given; values past kLargestHalf become infinite and are counted.
std::vector<uint16_t> to_half(std::span<const float> values, uint64_t& overflowed);

/// A multi-layer image as read: "beauty" (channels R G B without a layer name) and every layer of kLayers that has the
/// channels of its row; interleaved, row 0 at the top.
struct LayeredImage {
    Size2 size;
    std::map<std::string, std::vector<float>> layers;
};

/// One layer of an image, whatever it is called there.
struct ReadLayer {
    Size2 size;
    uint32_t channels = 0;
    std::vector<float> pixels;  // interleaved, row 0 at the top
};

struct JudgedImage {
    Size2 size;
    uint32_t channels = 0;
    std::vector<NamedLayer> layers;
};

/// Reads an EXR. Throws ErrorCode::BadImage, before any pixel memory is taken when the header is at fault: not an EXR,
/// refused by judge_image_file_header(), no R G B, sub-sampled data.
LayeredImage read_exr(const std::filesystem::path& path);

/// The same for an EXR or a Radiance HDR image, told apart by their first bytes; an HDR has the beauty only. Also
/// throws ErrorCode::OutOfMemory, before any pixel memory is taken, when the layers would take more than `limit_bytes`.
LayeredImage read_image(const std::filesystem::path& path, uint64_t limit_bytes = UINT64_MAX);

/// A layer of an image by its name in layers_of_channels(). Throws ErrorCode::UnknownName, saying which there are,
/// where it has none of that name; otherwise as read_image().
ReadLayer read_image_layer(const std::filesystem::path& path, const std::string& layer,
                           uint64_t limit_bytes = UINT64_MAX);

/// Judges an uploaded EXR or Radiance HDR image: header within the limits above, every pixel decodable. Throws
/// ErrorCode::BadImage.
JudgedImage judge_image(const std::filesystem::path& path);

/// Pays the image library's one-time costs, so that the first real encoding is as fast as the next.
void warm_up_exr();

}  // namespace photond
