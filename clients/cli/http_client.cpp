#include "clients/cli/http_client.h"

#include <httplib.h>

#include <algorithm>
#include <array>
#include <exception>

#include "clients/cli/failure.h"

namespace photond::cli {

namespace {

constexpr size_t kChunkBytes = 64 * 1024;

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    return text;
}

struct ServerAddress {
    std::string origin;     // http://host:port
    std::string base_path;  // "" or "/photond"
};

ServerAddress parse_server_address(const std::string& url) {
    const size_t scheme_end = url.find("://");
    const std::string scheme = scheme_end == std::string::npos ? "" : lower(url.substr(0, scheme_end));
    if (scheme != "http" && scheme != "https")
        throw Failure(ExitCode::Usage, "the server's address '" + url + "' is not an http:// or https:// URL",
                      "for example --server http://127.0.0.1:8080");
    const size_t path_start = url.find('/', scheme_end + 3);
    ServerAddress address{url.substr(0, path_start), path_start == std::string::npos ? "" : url.substr(path_start)};
    if (address.origin.size() == scheme_end + 3 || url.find_first_of("?# \t\n") != std::string::npos)
        throw Failure(ExitCode::Usage, "the server's address '" + url + "' must be scheme, host, port and path only");
    while (!address.base_path.empty() && address.base_path.back() == '/') address.base_path.pop_back();
    return address;
}

HttpReply reply_head(const httplib::Response& response) {
    HttpReply reply;
    reply.status = response.status;
    for (const auto& [name, value] : response.headers) reply.headers.emplace(lower(name), value);
    return reply;
}

TransportError transport_error(httplib::Error error, const std::string& origin, bool stopped) {
    if (stopped) return {TransportFault::Stopped, "stopped"};
    switch (error) {
        case httplib::Error::Connection: return {TransportFault::CannotConnect, "cannot connect to " + origin};
        case httplib::Error::ConnectionTimeout:
            return {TransportFault::CannotConnect, origin + " did not accept a connection in time"};
        case httplib::Error::SSLConnection:
        case httplib::Error::SSLLoadingCerts:
        case httplib::Error::SSLServerVerification:
            return {TransportFault::CannotConnect,
                    "no trusted TLS connection to " + origin + " (" + httplib::to_string(error) + ")"};
        case httplib::Error::Write:
            return {TransportFault::ConnectionLost, origin + " closed the connection while the request was sent"};
        case httplib::Error::Read:
            return {TransportFault::ConnectionLost,
                    origin + " closed the connection or fell silent before it answered"};
        default:
            return {TransportFault::ConnectionLost,
                    "the exchange with " + origin + " broke off (" + httplib::to_string(error) + ")"};
    }
}

}  // namespace

std::string HttpReply::header(const std::string& name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string() : found->second;
}

struct HttpClient::Connection {
    explicit Connection(const ServerAddress& server) : address(server), client(server.origin) {}
    ServerAddress address;
    httplib::Client client;
};

HttpClient::HttpClient(const std::string& url, std::chrono::milliseconds connect_limit,
                       std::chrono::milliseconds stall_limit)
    : connection_(std::make_unique<Connection>(parse_server_address(url))) {
    httplib::Client& client = connection_->client;
    if (!client.is_valid())
        throw Failure(ExitCode::Usage, "the server's address '" + url + "' has no usable host and port");
    client.set_connection_timeout(connect_limit);
    client.set_read_timeout(stall_limit);
    client.set_write_timeout(stall_limit);
    client.set_keep_alive(true);
    client.set_tcp_nodelay(true);
    client.set_follow_location(false);
    client.set_url_encode(false);  // paths arrive encoded
}

HttpClient::~HttpClient() = default;

void HttpClient::stop() { connection_->client.stop(); }

HttpReply HttpClient::exchange(const HttpRequest& request, const ReplySink* sink) {
    httplib::Request wire;
    wire.method = request.method;
    wire.path = connection_->address.base_path + request.path;
    for (const auto& [name, value] : request.headers) wire.headers.emplace(name, value);
    if (!request.content_type.empty()) wire.headers.emplace("Content-Type", request.content_type);
    wire.body = request.body;

    // A failure inside a callback must not unwind through the library: it is kept and thrown when the library returns.
    std::exception_ptr inner;
    std::vector<char> chunk;
    if (request.source) {
        chunk.resize(kChunkBytes);
        wire.content_length_ = request.source->size_bytes();
        wire.content_provider_ = [&](size_t offset, size_t length, httplib::DataSink& out) {
            try {
                const size_t count = request.source->read(offset, chunk.data(), std::min(length, chunk.size()));
                return out.write(chunk.data(), count);
            } catch (...) {
                inner = std::current_exception();
                return false;
            }
        };
    }

    HttpReply reply;
    bool stopped = false;
    wire.response_handler = [&](const httplib::Response& response) {
        reply = reply_head(response);
        try {
            if (sink && sink->head) stopped = !sink->head(reply);
        } catch (...) {
            inner = std::current_exception();
        }
        return !stopped && !inner;
    };
    wire.content_receiver = [&](const char* data, size_t length, uint64_t, uint64_t) {
        try {
            if (sink && sink->data && (reply.status == 200 || reply.status == 206))
                stopped = !sink->data(std::string_view(data, length));
            else
                reply.body.append(data, length);
        } catch (...) {
            inner = std::current_exception();
        }
        return !stopped && !inner;
    };

    httplib::Response response;
    httplib::Error error = httplib::Error::Success;
    const bool done = connection_->client.send(wire, response, error);
    if (inner) std::rethrow_exception(inner);
    if (!done) throw transport_error(error, connection_->address.origin, stopped);
    if (reply.status == 0) reply = reply_head(response);
    return reply;
}

std::string percent_encode(std::string_view text) {
    constexpr std::string_view kUnreserved = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";
    constexpr std::array<char, 16> kHex = {'0', '1', '2', '3', '4', '5', '6', '7',
                                           '8', '9', 'A', 'B', 'C', 'D', 'E', 'F'};
    std::string encoded;
    for (const char c : text) {
        if (kUnreserved.find(c) != std::string_view::npos) {
            encoded += c;
        } else {
            const auto byte = static_cast<unsigned char>(c);
            encoded += {'%', kHex[byte >> 4], kHex[byte & 15]};
        }
    }
    return encoded;
}

std::string percent_decode(std::string_view text) {
    const auto digit = [](char c) {
        if (c >= '0' && c <= '9') return c - '0';
        if (c >= 'a' && c <= 'f') return c - 'a' + 10;
        if (c >= 'A' && c <= 'F') return c - 'A' + 10;
        return -1;
    };
    std::string decoded;
    for (size_t i = 0; i < text.size(); ++i) {
        const bool escape = text[i] == '%' && i + 2 < text.size() && digit(text[i + 1]) >= 0 && digit(text[i + 2]) >= 0;
        decoded += escape ? static_cast<char>(digit(text[i + 1]) * 16 + digit(text[i + 2])) : text[i];
        if (escape) i += 2;
    }
    return decoded;
}

}  // namespace photond::cli
