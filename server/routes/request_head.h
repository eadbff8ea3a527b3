#pragma once
// A request's head, read and judged before anything else sees it. A pure function of bytes, so that it can be tested
// and fuzzed alone.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/error.h"

namespace photond::http {

struct HeadLimits {
    size_t max_bytes = 32 << 10;   // request line and all headers
    size_t max_line_bytes = 8000;  // cpp-httplib reads lines of 8192
    size_t max_lines = 128;
};

struct RequestHead {
    std::string method;
    std::string path;                                          // as sent, still percent-encoded, begins with '/'
    std::string query;                                         // as sent, without the '?'
    std::string host;                                          // without the port; IPv6 addresses keep their brackets
    std::string authority;                                     // host and port as sent
    std::vector<std::pair<std::string, std::string>> headers;  // names in lower case, values trimmed
    uint64_t content_length = 0;
    bool has_length = false;
    bool expects_continue = false;
    bool keep_alive = true;

    /// The first header of this (lower-case) name; nullptr when there is none.
    const std::string* header(std::string_view name) const;
    /// Media type without parameters, in lower case; empty when there is none.
    std::string media_type() const;
};

/// Looks for the end of a head in what has arrived so far.
class HeadScanner {
public:
    /// Length of the head with its empty line once all of it is in `bytes`; nothing while more must come. Looks only at
    /// bytes it has not seen. Throws Error: HeadTooLarge; BadRequest for a bare line feed or a control character.
    std::optional<size_t> scan(std::string_view bytes, const HeadLimits& limits);
    void restart() { *this = {}; }

private:
    size_t seen_ = 0;
    size_t line_begin_ = 0;
    size_t lines_ = 0;
    bool begun_ = false;  // the request line has begun; before it, empty lines are skipped
};

/// `head` ends with the empty line. Throws Error: BadRequest, LengthRequired for any transfer coding, WrongMediaType
/// for a content coding.
RequestHead parse_head(std::string_view head);

/// A parameter of a header, `; key=value` or `; key="value"`; nothing where it is absent. `wanted` in lower case.
std::optional<std::string> header_parameter(const std::string& header, std::string_view wanted);

/// The items of a header that is a list, such as "gzip;q=0.5, br", each with its parameters.
std::vector<std::string_view> list_items(std::string_view header);

/// Percent-decoding; nothing where an escape is malformed.
std::optional<std::string> percent_decode(std::string_view text);

}  // namespace photond::http
