#include "renderer/scene/texture_decode.h"

#include "protocol/error.h"
#include "renderer/core/image_module.h"

namespace photond {

Texture decode_texture(std::span<const uint8_t> encoded, const LoadLimits& limits) {
    static const auto decode = image_function<decltype(decode_texture)>("photond_decode_texture");
    return decode(encoded, limits);
}

ImageHeader judge_environment(std::span<const uint8_t> encoded, const LoadLimits& limits) {
    const ImageHeader header = read_image_header(encoded);
    if (header.format != ImageFormat::OpenExr && header.format != ImageFormat::RadianceHdr)
        throw Error(ErrorCode::BadImage, "", "an environment must be an OpenEXR or a Radiance HDR image");
    judge_image_size(header, encoded.size(), sizeof(Rgb), limits.max_texture_pixels);
    return header;
}

EnvironmentMap decode_environment(std::span<const uint8_t> encoded, const LoadLimits& limits) {
    static const auto decode = image_function<decltype(decode_environment)>("photond_decode_environment");
    return decode(encoded, limits);
}

}  // namespace photond
