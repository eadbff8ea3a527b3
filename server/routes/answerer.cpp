#include "server/routes/answerer.h"

#include <httplib.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <system_error>

#include "protocol/problem.h"
#include "server/asks_again.h"
#include "server/helper_wait.h"
#include "server/try_later.h"

namespace photond::http {
namespace {

// A request in, an answer out, no socket in sight.
class MemoryStream final : public httplib::Stream {
public:
    MemoryStream(std::string request, std::string& answer) : request_(std::move(request)), answer_(answer) {}

    bool is_readable() const override { return true; }
    bool is_writable() const override { return true; }
    ssize_t read(char* to, size_t size) override {
        const size_t n = std::min(size, request_.size() - read_);
        std::memcpy(to, request_.data() + read_, n);
        read_ += n;
        return static_cast<ssize_t>(n);
    }
    ssize_t write(const char* from, size_t size) override {
        answer_.append(from, size);
        return static_cast<ssize_t>(size);
    }
    void get_remote_ip_and_port(std::string&, int&) const override {}
    void get_local_ip_and_port(std::string&, int&) const override {}
    socket_t socket() const override { return INVALID_SOCKET; }

private:
    const std::string request_;
    std::string& answer_;
    size_t read_ = 0;
};

Reply internal_failure(const Exchange& exchange, const char* what) {
    static std::atomic<uint64_t> defects{0};
    const uint64_t number = ++defects;
    spdlog::error("defect {} in {} {}: {}", number, exchange.call.head.method, exchange.call.head.path, what);
    return problem_reply(Error(ErrorCode::Internal, "internal error, logged as defect " + std::to_string(number)),
                         exchange.call.head.path);
}

// What is short goes into the socket's own buffer at once; and what a write has done cannot be taken back.
void count_body(Exchange& exchange, size_t bytes) {
    constexpr size_t kShortBody_bytes = 64 << 10;
    if (!exchange.memory) return;
    const std::string& method = exchange.call.head.method;
    const bool is_read = method == "GET" || method == "HEAD";
    if (is_read && bytes > kShortBody_bytes)
        exchange.memory->take(bytes);
    else
        exchange.memory->hold(bytes);
}

/// Whether a header such as "wait=5, respond-async" asks not to be held.
bool prefers_to_ask_again(const RequestHead& head) {
    const std::string* preferences = head.header("prefer");
    if (preferences == nullptr) return false;
    const auto items = list_items(*preferences);
    return std::any_of(items.begin(), items.end(), [](std::string_view item) { return item == "respond-async"; });
}

Reply try_later_reply(const Exchange& exchange, const TryLater& later) {
    Reply reply;
    if (later.under_way && client_asks_again())
        reply.status = 202, reply.headers = {{"Cache-Control", "no-store"}, {"Preference-Applied", "respond-async"}};
    else
        reply = problem_reply(later, exchange.call.head.path);
    reply.headers["Retry-After"] = std::to_string(later.retry_after_seconds);
    return reply;
}

Reply reply_of(Exchange& exchange) {
    client_asks_again() = prefers_to_ask_again(exchange.call.head);
    try {
        if (exchange.refusal) throw *exchange.refusal;
        Reply reply = exchange.route->handle(exchange.call);
        count_body(exchange, reply.body.size());
        return reply;
    } catch (const ClientGone&) {
        exchange.client_gone = true;
        return {};
    } catch (AwaitJob& job) {
        exchange.awaits = std::move(job);
        return {};
    } catch (const NeedsHelper&) {
        exchange.needs_helper = true;
        return {};
    } catch (const Refusal& refusal) {
        Reply reply = problem_reply(refusal.error, exchange.call.head.path);
        for (const auto& [name, value] : refusal.headers) reply.headers[name] = value;
        return reply;
    } catch (const TryLater& error) {
        return try_later_reply(exchange, error);
    } catch (const Error& error) {
        if (error.code == ErrorCode::Internal) return internal_failure(exchange, error.what());
        Reply reply = problem_reply(error, exchange.call.head.path);
        if (reply.status == 429 || reply.status == 503) reply.headers["Retry-After"] = "1";
        return reply;
    } catch (const std::bad_alloc&) {
        return problem_reply(Error(ErrorCode::Unavailable, "the daemon is short of memory"), exchange.call.head.path);
    } catch (const std::system_error& error) {
        if (error.code() != std::errc::no_space_on_device) return internal_failure(exchange, error.what());
        return problem_reply(Error(ErrorCode::NoSpace, "there is no room on the disk for what the answer needs"),
                             exchange.call.head.path);
    } catch (const std::exception& defect) {
        return internal_failure(exchange, defect.what());
    }
}

// Of every answer, unless it has its own.
constexpr std::pair<const char*, const char*> kStandardHeaders[] = {
    {"Content-Security-Policy", "default-src 'self'; base-uri 'none'; form-action 'self'; frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Server", "photond"},
};

// The library would state a length; a stream has none.
std::string event_stream_head() {
    std::string head =
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n"
        "X-Accel-Buffering: no\r\nConnection: close\r\n";
    for (const auto& [name, value] : kStandardHeaders) head += std::string(name) + ": " + value + "\r\n";
    return head + "\r\n";
}

}  // namespace

class Answerer::Library final : public httplib::Server {
public:
    Library() {
        set_keep_alive_timeout(60);
        set_keep_alive_max_count(1'000'000);
        httplib::Headers headers;
        for (const auto& [name, value] : kStandardHeaders) headers.emplace(name, value);
        set_default_headers(std::move(headers));
        set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
            serve(request, response);
            return HandlerResponse::Handled;
        });
    }

    void run(Exchange& exchange, bool keep_alive) {
        exchange_ = &exchange;
        exchange.wire.clear();
        const RequestHead& head = exchange.call.head;
        // The library knows the method for HEAD's sake and the target for the query's; a refused request's own line may
        // be beyond it.
        std::string request = exchange.refusal ? (head.method == "HEAD" ? "HEAD / HTTP/1.1\r\n" : "GET / HTTP/1.1\r\n")
                                               : head.method + " /?" + head.query + " HTTP/1.1\r\n";
        request += keep_alive ? "\r\n" : "Connection: close\r\n\r\n";
        MemoryStream stream(std::move(request), exchange.wire);
        bool closed = false;
        process_request(stream, !keep_alive, closed, nullptr);
        if (exchange.reply.events) exchange.wire = event_stream_head() + exchange.reply.events->first;
    }

private:
    void serve(const httplib::Request& request, httplib::Response& response) {
        Exchange& exchange = *exchange_;
        exchange.call.query = {request.params.begin(), request.params.end()};
        exchange.reply = reply_of(exchange);
        Reply& reply = exchange.reply;
        response.status = reply.status;
        for (const auto& [name, value] : reply.headers) {
            response.headers.erase(name);  // in place of the standard one
            response.set_header(name, value);
        }
        if (reply.file || !reply.pieces.empty()) {
            uint64_t length = reply.file ? reply.file->length : 0;
            for (const std::string& piece : reply.pieces) length += piece.size();
            response.set_header("Content-Type", reply.media_type);
            response.set_header("Content-Length", std::to_string(length));
            if (request.method == "HEAD") reply.file.reset(), reply.pieces.clear();
        } else if (!reply.body.empty()) {
            response.set_content(reply.body, reply.media_type);
            reply.body.clear();
        }
    }

    Exchange* exchange_ = nullptr;
};

Answerer::Answerer() : library_(std::make_unique<Library>()) {}
Answerer::~Answerer() = default;

void Answerer::answer(Exchange& exchange, bool keep_alive) noexcept {
    try {
        library_->run(exchange, keep_alive);
    } catch (const std::exception& defect) {  // no memory even for a problem document: the connection is closed
        exchange.wire.clear();
        exchange.reply = {};
        spdlog::error("no answer could be made: {}", defect.what());
    }
}

Reply json_reply(int status, const nlohmann::json& body) {
    Reply reply;
    reply.status = status;
    reply.media_type = "application/json";
    reply.headers["Cache-Control"] = "no-store";
    reply.body = body.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
    return reply;
}

Reply json_text_reply(Call& call, const std::function<void(const std::function<void(std::string)>&)>& make) {
    Reply reply;
    reply.media_type = "application/json";
    reply.headers["Cache-Control"] = "no-store";
    if (call.before_piece) call.before_piece(0);
    make([&](std::string piece) {
        piece.shrink_to_fit();
        if (call.before_piece) call.before_piece(piece.size());
        reply.pieces.push_back(std::move(piece));
    });
    return reply;
}

Reply problem_reply(const Error& error, const std::string& instance) {
    Reply reply = json_reply(error_kind(error.code).http_status, problem_json(error, instance));
    reply.media_type = kProblemMediaType;
    return reply;
}

}  // namespace photond::http
