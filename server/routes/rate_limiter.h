#pragma once
#include <chrono>
#include <mutex>
#include <string>
#include <unordered_map>

namespace photond::http {

/// Token buckets, one a client. A bucket holds `capacity` requests: one second's worth, at least one, unless it is
/// said.
class RateLimiter {
public:
    using Clock = std::chrono::steady_clock;

    /// 0: no limit.
    explicit RateLimiter(double requests_per_second)
        : RateLimiter(requests_per_second, requests_per_second < 1 ? 1 : requests_per_second) {}
    RateLimiter(double requests_per_second, double capacity) : rate_(requests_per_second), capacity_(capacity) {}

    /// Seconds to wait before the next request of this client would be taken; 0: this one is.
    double take(const std::string& client, Clock::time_point now = Clock::now());

private:
    static constexpr size_t kMaxClients = 10'000;  // beyond it, buckets that have filled up again are forgotten

    struct Bucket {
        double requests = 0;
        Clock::time_point at{};
    };
    void forget_full(Clock::time_point now);

    const double rate_, capacity_;
    std::mutex mutex_;
    std::unordered_map<std::string, Bucket> buckets_;
};

}  // namespace photond::http
