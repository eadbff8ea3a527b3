// The part of png_file.h that needs OpenImageIO; in the image module (renderer/core/image_module.h).

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cassert>
#include <memory>

#include "protocol/error.h"
#include "renderer/film/png_file.h"

namespace photond {

extern "C" std::vector<uint8_t> photond_encode_png(Size2 size, std::span<const uint8_t> rgb, int compression) {
    assert(rgb.size() == 3 * size.pixels());
    OIIO::ImageSpec spec(static_cast<int>(size.width), static_cast<int>(size.height), 3, OIIO::TypeUInt8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("png:compressionLevel", compression);
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create("png");
    if (!output) throw Error(ErrorCode::Internal, "the image library cannot write PNG: " + OIIO::geterror());
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    if (!output->set_ioproxy(&memory) || !output->open("preview.png", spec) ||
        !output->write_image(OIIO::TypeUInt8, rgb.data()) || !output->close())
        throw Error(ErrorCode::Internal, "cannot encode the PNG: " + output->geterror());
    return bytes;
}

[[maybe_unused]] constexpr decltype(&photond_encode_png) kEncodePng = &encode_png;  // as png_file.cpp calls it

}  // namespace photond
