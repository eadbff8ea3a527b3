#include "server/routes/file_reply.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <charconv>

namespace photond::http {
namespace {

std::optional<uint64_t> decimal(std::string_view text) {
    uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

}  // namespace

bool lists_etag(std::string_view header, const std::string& quoted_etag, bool weak) {
    if (header.find_first_not_of(" \t*") == std::string_view::npos) return header.find('*') != std::string_view::npos;
    for (size_t at = header.find(quoted_etag); at != std::string_view::npos; at = header.find(quoted_etag, at + 1))
        if (weak || at < 2 || header.substr(at - 2, 2) != "W/") return true;
    return false;
}

ByteRange parse_range(const std::string& header, uint64_t bytes) {
    const ByteRange whole{ByteRange::Kind::Whole, 0, bytes};
    const ByteRange unsatisfiable{ByteRange::Kind::Unsatisfiable, 0, 0};
    std::string_view text = header;
    if (!text.starts_with("bytes=")) return whole;
    text.remove_prefix(6);
    const size_t dash = text.find('-');
    if (dash == std::string_view::npos || text.find(',') != std::string_view::npos) return whole;
    const std::optional<uint64_t> first = decimal(text.substr(0, dash)), last = decimal(text.substr(dash + 1));
    if (dash == 0) {  // the last so many bytes
        if (!last) return whole;
        if (*last == 0 || bytes == 0) return unsatisfiable;
        const uint64_t length = std::min(*last, bytes);
        return {ByteRange::Kind::Part, bytes - length, length};
    }
    if (!first || (dash + 1 < text.size() && !last) || (last && *last < *first)) return whole;
    if (*first >= bytes) return unsatisfiable;
    const uint64_t end = last ? std::min(*last, bytes - 1) : bytes - 1;
    return {ByteRange::Kind::Part, *first, end - *first + 1};
}

Reply file_reply(const Call& call, const Artefact& artefact) {
    Reply reply;
    if (artefact.pending) {
        reply.status = 202;
        reply.headers = {{"Retry-After", "1"}, {"Cache-Control", "no-store"}};
        return reply;
    }
    const std::string etag = "\"" + artefact.etag + "\"";
    for (const auto& [name, value] : artefact.headers) reply.headers[name] = value;
    reply.headers["ETag"] = etag;
    reply.headers["Cache-Control"] = "no-cache";  // keep it, and ask whether it is still good
    reply.headers["Accept-Ranges"] = "bytes";
    reply.media_type = artefact.media_type;
    if (const std::string* known = call.head.header("if-none-match"); known && lists_etag(*known, etag, true)) {
        reply.status = 304;
        return reply;
    }
    FileBody body;
    body.file = FileDescriptor(open(artefact.path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
    struct stat status {};
    if (!body.file || fstat(body.file.get(), &status) != 0 || !S_ISREG(status.st_mode))
        throw Error(ErrorCode::Internal, "the artefact " + artefact.path.string() + " cannot be opened");
    const auto bytes = static_cast<uint64_t>(status.st_size);
    ByteRange range{ByteRange::Kind::Whole, 0, bytes};
    if (const std::string* wanted = call.head.header("range")) {
        const std::string* condition = call.head.header("if-range");
        if (condition == nullptr || *condition == etag) range = parse_range(*wanted, bytes);
    }
    if (range.kind == ByteRange::Kind::Unsatisfiable)
        throw Refusal{Error(ErrorCode::RangeNotSatisfiable,
                            "the range lies outside the " + std::to_string(bytes) + " bytes there are"),
                      {{"Content-Range", "bytes */" + std::to_string(bytes)}}};
    if (range.kind == ByteRange::Kind::Part) {
        reply.status = 206;
        reply.headers["Content-Range"] = "bytes " + std::to_string(range.offset) + "-" +
                                         std::to_string(range.offset + range.length - 1) + "/" + std::to_string(bytes);
    }
    body.offset = range.offset;
    body.length = range.length;
    body.pin = artefact.pin;
    reply.file = std::move(body);
    return reply;
}

}  // namespace photond::http
