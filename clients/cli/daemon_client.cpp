#include "clients/cli/daemon_client.h"

#include <algorithm>
#include <charconv>
#include <random>

#include "clients/cli/units.h"

namespace photond::cli {

namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kConnectLimit{10};
constexpr std::chrono::seconds kStallLimit{180};  // a scene is answered only after it has been judged, 120 s at most
constexpr double kFirstPauseSeconds = 0.2;
constexpr double kLongestPauseSeconds = 5;
constexpr size_t kPageItems = 1000;  // the greatest `limit` the protocol allows

/// Retry-After in whole seconds; the form with a date is not used by the daemon.
std::optional<double> retry_after_seconds(const HttpReply& reply) {
    const std::string text = reply.header("retry-after");
    unsigned seconds = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seconds);
    if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return seconds;
}

/// Doubling pauses, each between half and all of its length, so that clients turned away together do not return
/// together.
class Pauses {
public:
    double next() {
        const double pause = length_ * std::uniform_real_distribution<double>(0.5, 1)(random_);
        length_ = std::min(2 * length_, kLongestPauseSeconds);
        return pause;
    }

private:
    double length_ = kFirstPauseSeconds;
    std::minstd_rand random_{std::random_device{}()};
};

}  // namespace

DaemonClient::DaemonClient(ServerOptions options, Interrupt& interrupt)
    : options_(std::move(options)), interrupt_(interrupt), http_(options_.url, kConnectLimit, kStallLimit) {}

std::vector<std::pair<std::string, std::string>> DaemonClient::common_headers() const {
    std::vector<std::pair<std::string, std::string>> headers{{"User-Agent", "photonctl/" PHOTOND_VERSION}};
    if (!options_.token.empty()) headers.emplace_back("Authorization", "Bearer " + options_.token);
    return headers;
}

HttpReply DaemonClient::ask(const HttpRequest& request, Repeat repeat, const ReplySink* sink) {
    HttpRequest wire = request;
    for (auto& header : common_headers()) wire.headers.push_back(std::move(header));

    const auto give_up = Clock::now() + std::chrono::duration<double>(options_.retry_seconds);
    const Interrupt::Stopper stopper(interrupt_, [this] { http_.stop(); });
    Pauses pauses;
    const auto pause_or_give_up = [&](std::optional<double> asked_for) {
        const double pause = std::max(asked_for.value_or(0), pauses.next());
        if (Clock::now() + std::chrono::duration<double>(pause) > give_up) return false;
        if (!interrupt_.sleep(std::chrono::duration<double>(pause))) throw interrupted(interrupt_.cause());
        return true;
    };

    while (true) {
        try {
            HttpReply reply = http_.exchange(wire, sink);
            spoken_to_ = true;
            if (reply.status >= 200 && reply.status < 300) return reply;
            const bool may_pass = reply.status == 429 || reply.status == 503;
            if (!may_pass || !pause_or_give_up(retry_after_seconds(reply))) throw refusal(reply);
        } catch (const TransportError& error) {
            if (interrupt_.cause() != Interrupt::Cause::None) throw interrupted(interrupt_.cause());
            if (error.fault == TransportFault::Stopped) throw;  // by the caller's own sink
            const bool lost = error.fault == TransportFault::ConnectionLost;
            const bool may_pass = lost ? repeat == Repeat::Safely : spoken_to_;
            if (may_pass && pause_or_give_up(std::nullopt)) continue;
            throw Failure(ExitCode::Unreachable, error.what(),
                          lost
                              ? "the daemon may have stopped; see its log, or run: photonctl doctor"
                              : "is the daemon running there? start it with deploy/quickstart or `photond --data DIR`; "
                                "another address: --server URL or PHOTOND_URL");
        }
    }
}

json DaemonClient::get(const std::string& path) {
    HttpRequest request;
    request.path = path;
    return json_of(ask(request, Repeat::Safely));
}

json DaemonClient::send(const std::string& method, const std::string& path, const json& body, Repeat repeat) {
    HttpRequest request;
    request.method = method;
    request.path = path;
    if (!body.is_null()) {
        request.body = body.dump();
        request.content_type = "application/json";
    }
    return json_of(ask(request, repeat));
}

std::vector<json> DaemonClient::list(const std::string& path_and_query, size_t limit) {
    std::vector<json> items;
    std::string cursor;
    const char separator = path_and_query.find('?') == std::string::npos ? '?' : '&';
    while (items.size() < limit) {
        const size_t page = std::min(kPageItems, limit - items.size());
        std::string path = path_and_query + separator + "limit=" + std::to_string(page);
        if (!cursor.empty()) path += "&cursor=" + percent_encode(cursor);
        const json reply = get(path);
        for (const json& item : reply.at("items")) items.push_back(item);
        const json next = reply.value("next_cursor", json());
        if (!next.is_string()) break;
        cursor = next.get<std::string>();
    }
    return items;
}

json json_of(const HttpReply& reply) {
    if (reply.body.empty()) return nullptr;
    json value = json::parse(reply.body, nullptr, false);
    if (value.is_discarded())
        throw Failure("the answer is not JSON: is this a photond daemon?",
                      json{{"title", "not JSON"}, {"status", reply.status}, {"detail", reply.body.substr(0, 200)}});
    return value;
}

Failure refusal(const HttpReply& reply) {
    json problem = json::parse(reply.body, nullptr, false);
    if (!problem.is_object())
        problem = {{"title", "HTTP " + std::to_string(reply.status)},
                   {"status", reply.status},
                   {"detail", printable(std::string_view(reply.body).substr(0, 300))}};
    const std::string title = problem.value("title", "HTTP " + std::to_string(reply.status));
    const std::string detail = problem.contains("detail") ? plain_text(problem["detail"]) : "";
    return {detail.empty() || detail == "-" ? printable(title) : printable(title) + ": " + detail, std::move(problem)};
}

Failure interrupted(Interrupt::Cause cause) {
    if (cause == Interrupt::Cause::Deadline) return {ExitCode::TimedOut, "--timeout passed"};
    return {ExitCode::Interrupted, "interrupted"};
}

std::string resource_path(const std::string& kind, const std::string& id) {
    return "/v1/" + kind + "/" + percent_encode(id);
}

}  // namespace photond::cli
