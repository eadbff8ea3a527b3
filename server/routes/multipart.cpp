#include "server/routes/multipart.h"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <vector>

#include "protocol/error.h"
#include "server/routes/exchange.h"

namespace photond::http {
namespace {

constexpr size_t kWindowBytes = 256 << 10;
constexpr size_t kMaxPartHeadBytes = 8 << 10;
constexpr size_t kMaxFiles = 4096;
constexpr size_t kMaxNameBytes = 256;

[[noreturn]] void malformed(const std::string& what) {
    throw Error(ErrorCode::BadRequest, "the multipart body is malformed: " + what);
}

std::string lower_case(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

class Reader {
public:
    explicit Reader(const std::filesystem::path& path) : file_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
        if (!file_) throw Error(ErrorCode::Internal, "the spooled body cannot be read");
        window_.reserve(2 * kWindowBytes);
    }
    std::string& window() { return window_; }
    /// Reads more into the window; false at the end.
    bool more() {
        const size_t before = window_.size();
        window_.resize(before + kWindowBytes);
        ssize_t n = 0;
        do n = read(file_.get(), window_.data() + before, kWindowBytes);
        while (n < 0 && errno == EINTR);
        window_.resize(before + static_cast<size_t>(std::max<ssize_t>(n, 0)));
        if (n < 0) throw Error(ErrorCode::Internal, "the spooled body cannot be read");
        return n > 0;
    }

private:
    FileDescriptor file_;
    std::string window_;
};

void write_all(int file, const char* data, size_t size) {
    while (size > 0) {
        const ssize_t n = write(file, data, size);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0)
            throw Error(errno == ENOSPC || errno == EDQUOT ? ErrorCode::NoSpace : ErrorCode::Unavailable,
                        std::string("an upload cannot be written: ") + std::strerror(errno));
        data += n;
        size -= static_cast<size_t>(n);
    }
}

struct PartHead {
    std::string field;
    std::optional<std::string> file_name;
};

PartHead read_part_head(Reader& reader) {
    std::string& window = reader.window();
    size_t end = std::string::npos;
    while ((end = window.find("\r\n\r\n")) == std::string::npos) {
        if (window.size() > kMaxPartHeadBytes) malformed("a part's head is too long");
        if (!reader.more()) malformed("it ends inside a part's head");
    }
    if (end > kMaxPartHeadBytes) malformed("a part's head is too long");
    PartHead head;
    bool disposition = false;
    for (size_t at = 0; at <= end;) {
        const size_t line_end = window.find("\r\n", at);
        const std::string line = window.substr(at, line_end - at);
        at = line_end + 2;
        const size_t colon = line.find(':');
        if (colon == std::string::npos) malformed("a part's head has a line without a colon");
        const std::string name = lower_case(line.substr(0, colon));
        if (name == "content-transfer-encoding" && lower_case(line).find("binary") == std::string::npos)
            malformed("transfer encodings of parts are not accepted");
        if (name != "content-disposition") continue;
        disposition = true;
        head.field = header_parameter(line, "name").value_or("");
        head.file_name = header_parameter(line, "filename");
    }
    if (!disposition) malformed("a part has no Content-Disposition");
    window.erase(0, end + 4);
    return head;
}

// Hands on everything up to the delimiter and consumes it too.
template <class Sink>
void read_part_body(Reader& reader, const std::string& delimiter, Sink&& sink) {
    std::string& window = reader.window();
    for (;;) {
        const size_t at = window.find(delimiter);
        if (at != std::string::npos) {
            sink(window.data(), at);
            window.erase(0, at + delimiter.size());
            return;
        }
        // The last bytes may be the first ones of a delimiter.
        if (window.size() >= delimiter.size()) {
            const size_t sure = window.size() - (delimiter.size() - 1);
            sink(window.data(), sure);
            window.erase(0, sure);
        }
        if (!reader.more()) malformed("the closing boundary is missing");
    }
}

std::string quoted_list(const std::map<std::string, size_t>& names) {
    std::string list;
    for (const auto& [name, bytes] : names) list += (list.empty() ? "\"" : " or \"") + name + "\"";
    return list;
}

FileDescriptor create_file(const std::filesystem::path& folder, const std::string& name) {
    check_relative_path(name);
    const std::filesystem::path path = folder / name;
    std::error_code failed;
    std::filesystem::create_directories(path.parent_path(), failed);  // of our own making: no links among them
    FileDescriptor file;
    if (!failed) file = FileDescriptor(open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (file) return file;
    if (failed == std::errc::no_space_on_device || (!failed && errno == ENOSPC))
        throw Error(ErrorCode::NoSpace, "the disk is full");
    throw Error(ErrorCode::Conflict, "the file name \"" + name + "\" appears twice, or as a file and as a folder");
}

}  // namespace

std::string multipart_boundary(const std::string& content_type) {
    const std::optional<std::string> boundary = header_parameter(content_type, "boundary");
    if (!boundary || boundary->empty() || boundary->size() > 70)
        throw Error(ErrorCode::BadRequest, "the Content-Type has no boundary of 1 to 70 characters");
    return *boundary;
}

void check_relative_path(const std::string& name) {
    const auto refuse = [&](const char* why) {
        throw Error(ErrorCode::OutOfRange, "the file name \"" + name.substr(0, 300) + "\" " + why);
    };
    if (name.empty()) refuse("is empty");
    if (name.front() == '/') refuse("is absolute; names are relative to the .gltf");
    if (name.find('\\') != std::string::npos) refuse("has a backslash; folders are separated by '/'");
    for (const char c : name)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) refuse("has a control character");
    size_t levels = 0;
    for (size_t at = 0; at <= name.size();) {
        const size_t end = std::min(name.find('/', at), name.size());
        const std::string part = name.substr(at, end - at);
        if (part.empty()) refuse("has an empty part");
        if (part == "." || part == "..") refuse("has a part \".\" or \"..\"");
        if (part.size() > 255) refuse("has a part of more than 255 bytes");
        if (++levels > 16) refuse("has more than 16 levels");
        at = end + 1;
    }
}

UploadedForm unpack_form(const std::filesystem::path& body, const std::string& boundary,
                         const std::filesystem::path& folder, const std::map<std::string, size_t>& fields) {
    Reader reader(body);
    UploadedForm form;
    std::map<std::string, size_t> known = fields;
    known.emplace("name", kMaxNameBytes);
    const std::string delimiter = "\r\n--" + boundary;
    reader.window() = "\r\n";                                       // so that the first boundary looks like all others
    read_part_body(reader, delimiter, [](const char*, size_t) {});  // a preamble means nothing
    for (;;) {
        std::string& window = reader.window();
        while (window.size() < 2)
            if (!reader.more()) malformed("the closing boundary is missing");
        if (window.starts_with("--")) break;
        // Transport padding after a boundary is allowed by RFC 2046 and used by nobody.
        if (!window.starts_with("\r\n")) malformed("a boundary is followed by other text");
        window.erase(0, 2);
        const PartHead head = read_part_head(reader);
        const auto field = known.find(head.field);
        if (field == known.end() && !head.file_name)
            throw Error(
                ErrorCode::UnknownField, "/" + head.field.substr(0, 64),
                "the form's field \"" + head.field.substr(0, 64) + "\" is neither a file nor " + quoted_list(known));
        if (field == known.end() || (head.file_name && !fields.contains(head.field))) {
            if (++form.files > kMaxFiles)
                throw Error(ErrorCode::OutOfRange, "more than " + std::to_string(kMaxFiles) + " files in one upload");
            const FileDescriptor file = create_file(folder, *head.file_name);
            read_part_body(reader, delimiter,
                           [&](const char* data, size_t size) { write_all(file.get(), data, size); });
            continue;
        }
        std::string& value = form.fields[head.field];
        value.clear();
        read_part_body(reader, delimiter, [&](const char* data, size_t size) {
            if (value.size() + size > field->second)
                throw Error(ErrorCode::OutOfRange, "/" + head.field,
                            head.field + " has more than " + std::to_string(field->second) + " bytes");
            value.append(data, size);
        });
    }
    return form;
}

}  // namespace photond::http
