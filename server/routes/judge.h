#pragma once
// Everything a request can be judged by from its head alone, before a byte of its body is read.

#include <vector>

#include "server/routes/exchange.h"
#include "server/routes/rate_limiter.h"

namespace photond::http {

struct JudgeSettings {
    bool loopback = true;  // listens on a loopback address only
    uint64_t max_json_bytes = 1 << 20;
    uint64_t max_upload_bytes = 2ull << 30;
    double max_requests_per_second = 0;
    std::function<void(uint64_t bytes)> check_disk;  // throws NoSpace
};

class Judge {
public:
    /// `routes` and `tokens` (nullptr: no authentication) are borrowed.
    Judge(JudgeSettings settings, const std::vector<Route>& routes, const TokenList* tokens);

    /// Fills exchange.route, call.path_parameters and call.grant. Throws Error or Refusal.
    void operator()(Exchange& exchange);

private:
    void check_host(const RequestHead& head) const;
    void check_origin(const RequestHead& head) const;
    void find_route(Exchange& exchange) const;
    void check_token(Exchange& exchange);
    [[noreturn]] void refuse_guess(const std::string& peer);
    void check_rate(const Exchange& exchange);
    void check_body(const Exchange& exchange) const;

    const JudgeSettings settings_;
    const std::vector<Route>& routes_;
    const TokenList* const tokens_;
    RateLimiter rates_;
    RateLimiter guesses_,
        told_of_;  // of tokens that nobody has, by address; and of lines of the log about more of them
};

}  // namespace photond::http
