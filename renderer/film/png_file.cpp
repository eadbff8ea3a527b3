#include "renderer/film/png_file.h"

#include "renderer/core/atomic_file.h"
#include "renderer/core/image_module.h"

namespace photond {

std::vector<uint8_t> encode_png(Size2 size, std::span<const uint8_t> rgb, int compression) {
    static const auto encode = image_function<decltype(encode_png)>("photond_encode_png");
    return encode(size, rgb, compression);
}

void write_png(Size2 size, std::span<const uint8_t> rgb, const std::filesystem::path& path) {
    // Previews are small: encoded in memory, so that a failed write is ours to name.
    const std::vector<uint8_t> bytes = encode_png(size, rgb);
    AtomicFile file(path);
    file.write(bytes.data(), bytes.size());
    file.commit();
}

}  // namespace photond
