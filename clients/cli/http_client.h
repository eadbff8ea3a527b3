#pragma once
// One HTTP exchange at a time with one server. No other file of the clients sees the HTTP library.

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace photond::cli {

/// Bytes to send whose length is known before and which can be read again from the start (a retry does).
class BodySource {
public:
    virtual ~BodySource() = default;
    virtual uint64_t size_bytes() const = 0;
    /// Fills `buffer` with at most `capacity` bytes from `offset`; at least one below size_bytes(). Throws Failure when
    /// a file cannot be read or has changed its length.
    virtual size_t read(uint64_t offset, char* buffer, size_t capacity) = 0;
};

struct HttpRequest {
    std::string method = "GET";
    std::string path;  // with its query, percent-encoded, below the server's address
    std::vector<std::pair<std::string, std::string>> headers;
    std::string body;
    BodySource* source = nullptr;  // takes the place of `body` when set
    std::string content_type;
};

struct HttpReply {
    int status = 0;
    std::map<std::string, std::string> headers;  // names in lower case
    std::string body;

    /// Empty when there is no such header; `name` in lower case.
    std::string header(const std::string& name) const;
};

/// Takes a reply as it arrives. `head` is called once; `data` only for status 200 and 206, other bodies are collected
/// in the reply. Returning false ends the exchange with TransportFault::Stopped.
struct ReplySink {
    std::function<bool(const HttpReply&)> head;
    std::function<bool(std::string_view)> data;
};

enum class TransportFault : uint8_t {
    CannotConnect,   // nothing was sent
    ConnectionLost,  // the request may have been carried out
    Stopped,         // by stop() or a sink
};

class TransportError : public std::runtime_error {
public:
    TransportError(TransportFault transport_fault, const std::string& message)
        : std::runtime_error(message), fault(transport_fault) {}
    const TransportFault fault;
};

class HttpClient {
public:
    /// `url`: http or https, host, port and an optional path that is put before every request's. Throws Failure(Usage)
    /// when it is none. A read or write that makes no headway for `stall_limit` ends as ConnectionLost.
    HttpClient(const std::string& url, std::chrono::milliseconds connect_limit, std::chrono::milliseconds stall_limit);
    ~HttpClient();

    /// Throws TransportError. Any status is a reply.
    HttpReply exchange(const HttpRequest& request, const ReplySink* sink = nullptr);
    /// From any thread: ends the exchange under way, if there is one.
    void stop();

private:
    struct Connection;
    std::unique_ptr<Connection> connection_;
};

/// Percent-encodes one segment or query value (RFC 3986: all but the unreserved characters).
std::string percent_encode(std::string_view text);
/// Decodes %XX; a stray % is kept.
std::string percent_decode(std::string_view text);

}  // namespace photond::cli
