#include "renderer/scene/bundle_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iterator>

#include "protocol/error.h"

namespace photond {

namespace {

[[noreturn]] void bad(const std::string& pointer, const std::string& detail) {
    throw Error(ErrorCode::BadScene, pointer, detail);
}

struct FileDescriptor {
    explicit FileDescriptor(int opened) : number(opened) {}
    ~FileDescriptor() { take(-1); }
    FileDescriptor(const FileDescriptor&) = delete;
    FileDescriptor& operator=(const FileDescriptor&) = delete;
    void take(int opened) {
        if (number >= 0) ::close(number);
        number = opened;
    }
    int number;
};

/// Opens a folder's file without following a link or leaving the folder, whatever others do to it meanwhile: each part
/// of the path is opened in the one before. (openat2 does the same, but a worker's sandbox cannot see its flags, and so
/// forbids it.) -1 and errno when it cannot: EXDEV for a path that leads out, ELOOP for one through a link.
int open_beneath(int root, const std::filesystem::path& path) {
    FileDescriptor folder(-1);
    if (path.is_absolute()) return errno = EXDEV, -1;
    for (auto part = path.begin(); part != path.end(); ++part) {
        if (*part == "..") return errno = EXDEV, -1;
        const bool last = std::next(part) == path.end();
        const int in = folder.number < 0 ? root : folder.number;
        // A pipe must not hold us up before it is refused.
        const int flags = last ? O_RDONLY | O_NOCTTY | O_NONBLOCK : O_PATH | O_DIRECTORY;
        const int opened = ::openat(in, part->c_str(), flags | O_NOFOLLOW | O_CLOEXEC);
        if (last && opened >= 0) return opened;
        if (opened < 0) {
            const int error = errno;
            struct stat entry {};
            const bool link = ::fstatat(in, part->c_str(), &entry, AT_SYMLINK_NOFOLLOW) == 0 && S_ISLNK(entry.st_mode);
            return errno = link ? ELOOP : error, -1;
        }
        folder.take(opened);
    }
    return errno = ENOENT, -1;
}

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

std::string percent_decoded(std::string_view uri, const std::string& pointer) {
    std::string text;
    text.reserve(uri.size());
    for (size_t i = 0; i < uri.size(); ++i) {
        if (uri[i] != '%') {
            text += uri[i];
            continue;
        }
        const int high = i + 2 < uri.size() ? hex_digit(uri[i + 1]) : -1;
        const int low = i + 2 < uri.size() ? hex_digit(uri[i + 2]) : -1;
        if (high < 0 || low < 0) bad(pointer, "the URI has a % that two hexadecimal digits do not follow");
        text += static_cast<char>(high * 16 + low);
        i += 2;
    }
    return text;
}

constexpr std::array<int8_t, 256> make_base64_values() {
    std::array<int8_t, 256> values{};
    values.fill(-1);
    constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < alphabet.size(); ++i) values[static_cast<uint8_t>(alphabet[i])] = static_cast<int8_t>(i);
    return values;
}
constexpr std::array<int8_t, 256> kBase64Values = make_base64_values();

}  // namespace

BundleFiles::BundleFiles(const std::filesystem::path& root, uint64_t max_bytes)
    : root_(::open(root.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)), bytes_left_(max_bytes) {
    if (root_ < 0) bad("", "the scene's folder cannot be opened: " + std::string(std::strerror(errno)));
}

BundleFiles::~BundleFiles() { ::close(root_); }

std::vector<uint8_t> BundleFiles::read(const std::string& relative_path, const std::string& pointer) {
    const std::string shown = "the file \"" + relative_path.substr(0, 200) + "\" ";
    const FileDescriptor file(open_beneath(root_, relative_path));
    if (file.number < 0) {
        if (errno == EXDEV || errno == ELOOP) bad(pointer, shown + "leads out of the scene's folder or through a link");
        bad(pointer, shown + "cannot be opened: " + std::strerror(errno));
    }
    struct stat status {};
    if (::fstat(file.number, &status) != 0) bad(pointer, shown + "cannot be examined: " + std::strerror(errno));
    if (!S_ISREG(status.st_mode)) bad(pointer, shown + "is not a regular file");
    const auto size = static_cast<uint64_t>(status.st_size);
    if (size > bytes_left_)
        bad(pointer, shown + "of " + std::to_string(size) + " bytes passes the limit on a scene's files, of which " +
                         std::to_string(bytes_left_) + " bytes are left");
    bytes_left_ -= size;
    std::vector<uint8_t> bytes(size);
    size_t done = 0;
    while (done < size) {
        const ssize_t got = ::read(file.number, bytes.data() + done, size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) bad(pointer, shown + "cannot be read: " + std::strerror(errno));
        if (got == 0) break;  // shortened since fstat: the caller's own length checks speak
        done += static_cast<size_t>(got);
    }
    bytes.resize(done);
    bytes_read_ += done;
    return bytes;
}

std::string path_of_uri(std::string_view uri, const std::string& pointer) {
    std::string path = percent_decoded(uri, pointer);
    if (path.empty()) bad(pointer, "the URI is empty");
    if (path.size() > 4096) bad(pointer, "the URI is longer than 4096 characters");
    for (const char c : path)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) bad(pointer, "the URI holds a control character");
    const std::string shown = "the URI \"" + path.substr(0, 200) + "\" ";
    if (path.front() == '/' || path.front() == '\\')
        bad(pointer, shown + "is absolute; files come from the bundle only");
    if (const size_t colon = path.find(':'); colon != std::string::npos && path.find('/') > colon)
        bad(pointer, shown + "has a scheme; only files of the bundle and data URIs are read");
    for (size_t begin = 0; begin <= path.size();) {
        const size_t end = std::min(path.find_first_of("/\\", begin), path.size());
        if (std::string_view(path).substr(begin, end - begin) == "..")
            bad(pointer, shown + "leads upwards (..); files come from the bundle only");
        begin = end + 1;
    }
    return path;
}

bool is_data_uri(std::string_view uri) { return uri.starts_with("data:"); }

std::vector<uint8_t> decode_data_uri(std::string_view uri, const std::string& pointer) {
    const size_t comma = uri.find(',');
    if (comma == std::string_view::npos) bad(pointer, "the data URI has no comma");
    if (!uri.substr(0, comma).ends_with(";base64")) bad(pointer, "the data URI is not base64");
    std::string_view text = uri.substr(comma + 1);
    while (text.ends_with('=') && text.size() + 2 > uri.size() - comma - 1) text.remove_suffix(1);  // at most two
    if (text.size() % 4 == 1) bad(pointer, "the data URI's base64 is cut short");
    std::vector<uint8_t> bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    uint32_t bits = 0;
    int held = 0;
    for (size_t i = 0; i < text.size(); ++i) {
        const int8_t value = kBase64Values[static_cast<uint8_t>(text[i])];
        if (value < 0) bad(pointer, "the data URI has a character outside base64 at " + std::to_string(comma + 1 + i));
        bits = bits << 6 | static_cast<uint32_t>(value);
        held += 6;
        if (held >= 8) {
            held -= 8;
            bytes.push_back(static_cast<uint8_t>(bits >> held));
        }
    }
    return bytes;
}

}  // namespace photond
