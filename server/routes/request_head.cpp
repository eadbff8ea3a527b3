#include "server/routes/request_head.h"

#include <algorithm>
#include <charconv>

namespace photond::http {
namespace {

// RFC 9110, 5.6.2.
bool is_token_char(char c) {
    if ((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z')) return true;
    return std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
}
bool is_token(std::string_view text) { return !text.empty() && std::all_of(text.begin(), text.end(), is_token_char); }

std::string lower_case(std::string_view text) {
    std::string lower(text);
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return lower;
}

std::string_view trim(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

[[noreturn]] void bad(const std::string& detail) { throw Error(ErrorCode::BadRequest, detail); }

std::string_view next_line(std::string_view& rest) {
    const size_t end = rest.find("\r\n");
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(end + 2);
    return line;
}

bool lists(std::string_view value, std::string_view word) {
    while (!value.empty()) {
        const size_t comma = value.find(',');
        if (lower_case(trim(value.substr(0, comma))) == word) return true;
        if (comma == std::string_view::npos) break;
        value.remove_prefix(comma + 1);
    }
    return false;
}

void split_authority(RequestHead& head) {
    const std::string& authority = head.authority;
    size_t host_end = authority.find(':');
    if (authority.starts_with('[')) {
        const size_t bracket = authority.find(']');
        if (bracket == std::string::npos) bad("the Host header is malformed");
        host_end = bracket + 1 < authority.size() ? bracket + 1 : std::string::npos;
    }
    head.host = lower_case(authority.substr(0, host_end));
    const std::string_view port = host_end == std::string::npos ? "" : std::string_view(authority).substr(host_end);
    const bool port_is_good =
        port.empty() || (port[0] == ':' && port.size() <= 6 &&
                         std::all_of(port.begin() + 1, port.end(), [](char c) { return c >= '0' && c <= '9'; }));
    const bool host_is_good = !head.host.empty() && std::all_of(head.host.begin(), head.host.end(), [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') ||
               std::string_view("-._[]:%").find(c) != std::string::npos;
    });
    if (!port_is_good || !host_is_good) bad("the Host header is malformed");
}

void parse_request_line(std::string_view line, RequestHead& head, int& minor_version) {
    const size_t first = line.find(' ');
    const size_t last = line.rfind(' ');
    if (first == std::string_view::npos || first == last) bad("the request line is malformed");
    const std::string_view method = line.substr(0, first), version = line.substr(last + 1);
    std::string_view target = line.substr(first + 1, last - first - 1);
    if (!is_token(method) || method.size() > 16) bad("the request's method is malformed");
    if (version != "HTTP/1.1" && version != "HTTP/1.0") bad("only HTTP/1.1 and HTTP/1.0 are spoken here");
    minor_version = version.back() - '0';
    if (target.find(' ') != std::string_view::npos) bad("the request's target contains a space");
    if (target.starts_with("http://")) {  // absolute form: as sent to proxies, and every server must take it
        target.remove_prefix(7);
        const size_t slash = target.find_first_of("/?");
        head.authority = target.substr(0, slash);
        if (head.authority.empty()) bad("the request's target is malformed");
        target = slash == std::string_view::npos ? "/" : target.substr(slash);
    }
    // In the absolute form, no path is the path "/".
    const bool no_path = !head.authority.empty() && target.starts_with('?');
    if (!target.starts_with('/') && !no_path) bad("the request's target must begin with '/'");
    for (const char c : target)
        if (static_cast<unsigned char>(c) <= 0x20 || static_cast<unsigned char>(c) >= 0x7f || c == '#')
            bad("the request's target contains a character that must be percent-encoded");
    const size_t question = target.find('?');
    head.method = method;
    head.path = no_path ? "/" : target.substr(0, question);
    if (question != std::string_view::npos) head.query = target.substr(question + 1);
}

void read_length(const std::string& value, RequestHead& head) {
    if (head.has_length) bad("two Content-Length headers");
    if (value.empty() || !std::all_of(value.begin(), value.end(), [](char c) { return c >= '0' && c <= '9'; }))
        bad("Content-Length must be a plain decimal number");
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), head.content_length);
    (void)end;
    if (error != std::errc()) throw Error(ErrorCode::PayloadTooLarge, "Content-Length is beyond 64 bits");
    head.has_length = true;
}

}  // namespace

const std::string* RequestHead::header(std::string_view name) const {
    for (const auto& [key, value] : headers)
        if (key == name) return &value;
    return nullptr;
}

std::string RequestHead::media_type() const {
    const std::string* value = header("content-type");
    return value == nullptr ? "" : lower_case(trim(std::string_view(*value).substr(0, value->find(';'))));
}

std::optional<size_t> HeadScanner::scan(std::string_view bytes, const HeadLimits& limits) {
    for (; seen_ < bytes.size(); ++seen_) {
        const char c = bytes[seen_];
        if (seen_ >= limits.max_bytes)
            throw Error(ErrorCode::HeadTooLarge,
                        "the request's head is larger than " + std::to_string(limits.max_bytes) + " bytes");
        if (c == '\n') {
            if (seen_ == 0 || bytes[seen_ - 1] != '\r') bad("a line of the head ends without a carriage return");
            const size_t length = seen_ - 1 - line_begin_;
            line_begin_ = seen_ + 1;
            if (length == 0 && begun_) return ++seen_;
            if (length > 0) begun_ = true;
            if (++lines_ > limits.max_lines)
                throw Error(ErrorCode::HeadTooLarge,
                            "the request's head has more than " + std::to_string(limits.max_lines) + " lines");
            continue;
        }
        if (seen_ > 0 && bytes[seen_ - 1] == '\r') bad("a carriage return inside a line of the head");
        if ((static_cast<unsigned char>(c) < 0x20 && c != '\r' && c != '\t') || c == 0x7f)
            bad("a control character in the head");
        if (seen_ - line_begin_ >= limits.max_line_bytes)
            throw Error(ErrorCode::HeadTooLarge,
                        "a line of the head is longer than " + std::to_string(limits.max_line_bytes) + " bytes");
    }
    return std::nullopt;
}

RequestHead parse_head(std::string_view rest) {
    RequestHead head;
    int minor_version = 1;
    while (rest.starts_with("\r\n")) rest.remove_prefix(2);
    parse_request_line(next_line(rest), head, minor_version);

    bool has_host = false, has_transfer_coding = false, close = false, keep = false;
    for (std::string_view line = next_line(rest); !line.empty(); line = next_line(rest)) {
        if (line.front() == ' ' || line.front() == '\t') bad("folded headers are not accepted");
        const size_t colon = line.find(':');
        if (colon == std::string_view::npos || !is_token(line.substr(0, colon))) bad("a header's name is malformed");
        std::string name = lower_case(line.substr(0, colon));
        std::string value(trim(line.substr(colon + 1)));
        if (name == "host") {
            if (has_host) bad("two Host headers");
            has_host = true;
            if (head.authority.empty()) head.authority = value;
        } else if (name == "content-length") {
            read_length(value, head);
        } else if (name == "transfer-encoding") {
            has_transfer_coding = true;
        } else if (name == "content-encoding") {
            if (lower_case(value) != "identity")
                throw Error(ErrorCode::WrongMediaType, "a body with a content coding is not accepted; send it plain");
        } else if (name == "connection") {
            close = close || lists(value, "close");
            keep = keep || lists(value, "keep-alive");
        } else if (name == "expect") {
            if (lower_case(value) != "100-continue") bad("the only Expect known here is 100-continue");
            head.expects_continue = minor_version == 1;
        }
        head.headers.emplace_back(std::move(name), std::move(value));
    }
    if (!has_host && minor_version == 1) bad("the Host header is missing");
    if (!head.authority.empty()) split_authority(head);
    if (has_transfer_coding) {
        if (head.has_length) bad("Content-Length together with Transfer-Encoding");
        throw Error(ErrorCode::LengthRequired, "transfer codings are not accepted: state the body's Content-Length");
    }
    head.keep_alive = !close && (minor_version == 1 || keep);
    return head;
}

std::optional<std::string> header_parameter(const std::string& header, std::string_view wanted) {
    size_t at = header.find(';');
    while (at != std::string::npos && at < header.size()) {
        at = header.find_first_not_of("; \t", at);
        if (at == std::string::npos) break;
        const size_t equals = header.find('=', at);
        if (equals == std::string::npos) break;
        const std::string key = lower_case(header.substr(at, equals - at));
        std::string value;
        at = equals + 1;
        if (at < header.size() && header[at] == '"') {
            for (++at; at < header.size() && header[at] != '"'; ++at) {
                // Browsers and curl escape the quote and the backslash only.
                if (header[at] == '\\' && at + 1 < header.size() && (header[at + 1] == '"' || header[at + 1] == '\\'))
                    ++at;
                value += header[at];
            }
            at = header.find(';', at);
        } else {
            const size_t end = header.find(';', at);
            value = header.substr(at, end == std::string::npos ? end : end - at);
            while (!value.empty() && (value.back() == ' ' || value.back() == '\t')) value.pop_back();
            at = end;
        }
        if (key == wanted) return value;
    }
    return std::nullopt;
}

std::vector<std::string_view> list_items(std::string_view header) {
    constexpr std::string_view kBlank = " \t";
    std::vector<std::string_view> items;
    while (!header.empty()) {
        std::string_view item = header.substr(0, header.find(','));
        header.remove_prefix(std::min(header.size(), item.size() + 1));
        item.remove_prefix(std::min(item.size(), item.find_first_not_of(kBlank)));
        item = item.substr(0, item.find_last_not_of(kBlank) + 1);
        if (!item.empty()) items.push_back(item);
    }
    return items;
}

std::optional<std::string> percent_decode(std::string_view text) {
    std::string decoded;
    for (size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            decoded += text[i];
            continue;
        }
        unsigned value = 0;
        if (i + 2 >= text.size()) return std::nullopt;
        const auto [end, error] = std::from_chars(text.data() + i + 1, text.data() + i + 3, value, 16);
        if (error != std::errc() || end != text.data() + i + 3) return std::nullopt;
        decoded += static_cast<char>(value);
        i += 2;
    }
    return decoded;
}

}  // namespace photond::http
