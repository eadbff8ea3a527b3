#include "clients/cli/exr_attribute.h"

#include <array>
#include <cstdint>
#include <fstream>

#include "clients/cli/failure.h"

namespace photond::cli {

namespace {

// "OpenEXR File Layout", openexr.com: magic number and version, then attributes until one whose name is empty, each a
// name and a type that end with a zero byte, the number of bytes and the bytes. Numbers are little-endian.
constexpr uint32_t kMagic = 20000630;
constexpr size_t kLongestName = 255;
constexpr uint32_t kLargestAttribute = 64u << 20;

class HeaderReader {
public:
    explicit HeaderReader(const std::filesystem::path& file) : file_(file), in_(file, std::ios::binary) {
        if (!in_) throw Failure(ExitCode::Usage, "cannot read " + file.string());
    }

    uint32_t number() {
        std::array<char, 4> bytes{};
        if (!in_.read(bytes.data(), bytes.size())) fail();
        uint32_t value = 0;
        for (size_t i = 0; i < bytes.size(); ++i) value |= uint32_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
        return value;
    }

    std::string name() {
        std::string text;
        for (char c = 0; in_.get(c);) {
            if (c == 0) return text;
            text += c;
            if (text.size() > kLongestName) break;
        }
        fail();
    }

    std::string bytes(uint32_t count) {
        if (count > kLargestAttribute) fail();
        std::string value(count, '\0');
        if (!in_.read(value.data(), count)) fail();
        return value;
    }

    [[noreturn]] void fail() const {
        throw Failure(ExitCode::Usage, file_.string() + " is no OpenEXR file, or not a whole one");
    }

private:
    const std::filesystem::path file_;
    std::ifstream in_;
};

}  // namespace

std::optional<std::string> exr_text_attribute(const std::filesystem::path& file, const std::string& name) {
    HeaderReader header(file);
    if (header.number() != kMagic) header.fail();
    header.number();  // version and flags
    while (true) {
        const std::string attribute = header.name();
        if (attribute.empty()) return std::nullopt;
        const std::string type = header.name();
        std::string value = header.bytes(header.number());
        if (attribute == name && type == "string") return value;
    }
}

}  // namespace photond::cli
