#pragma once
// The daemon's API as the commands use it: bearer token, repeats after 429, 503 and lost connections, problems turned
// into Failures.

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "clients/cli/failure.h"
#include "clients/cli/http_client.h"
#include "clients/cli/interrupt.h"

namespace photond::cli {

struct ServerOptions {
    std::string url = "http://127.0.0.1:8080";
    std::string token;          // empty: none is sent
    double retry_seconds = 30;  // how long failures that may pass are repeated; 0: never
};

/// What may be sent again after a connection was lost in the middle, when nobody knows whether it was carried out.
enum class Repeat : unsigned char { Safely, OnlyIfRefused };

class DaemonClient {
public:
    DaemonClient(ServerOptions options, Interrupt& interrupt);

    const ServerOptions& options() const { return options_; }
    Interrupt& interrupt() { return interrupt_; }

    /// Any 2xx reply. Repeats 429 and 503 after the Retry-After they name (else 0.2 s doubling to 5 s, jittered), lost
    /// connections where `repeat` allows, and refused ones once the daemon has been spoken to; all within
    /// `retry_seconds`. Throws Failure: Unreachable, Refused with the daemon's problem, Interrupted or TimedOut.
    HttpReply ask(const HttpRequest& request, Repeat repeat, const ReplySink* sink = nullptr);

    nlohmann::json get(const std::string& path);
    nlohmann::json send(const std::string& method, const std::string& path, const nlohmann::json& body, Repeat repeat);
    /// At most `limit` items of a list, over as many pages as that takes.
    std::vector<nlohmann::json> list(const std::string& path_and_query, size_t limit);

    /// Authorization, and what every request carries.
    std::vector<std::pair<std::string, std::string>> common_headers() const;

private:
    ServerOptions options_;
    Interrupt& interrupt_;
    HttpClient http_;
    bool spoken_to_ = false;  // one reply has come: a refused connection now means a restart
};

/// The JSON of a reply; throws Failure(Refused) where it is none.
nlohmann::json json_of(const HttpReply& reply);
/// The Failure of a reply that is no 2xx.
Failure refusal(const HttpReply& reply);
/// What an interrupt ends a wait with.
Failure interrupted(Interrupt::Cause cause);

/// "/v1/KIND/ID" with the id encoded.
std::string resource_path(const std::string& kind, const std::string& id);

}  // namespace photond::cli
