#include "server/routes/rate_limiter.h"

#include <algorithm>

namespace photond::http {

double RateLimiter::take(const std::string& client, Clock::time_point now) {
    if (rate_ <= 0) return 0;
    const std::lock_guard lock(mutex_);
    if (buckets_.size() >= kMaxClients && !buckets_.contains(client)) forget_full(now);
    const auto [place, is_new] = buckets_.try_emplace(client, Bucket{capacity_, now});
    (void)is_new;
    Bucket& bucket = place->second;
    const double passed_seconds = std::chrono::duration<double>(now - bucket.at).count();
    bucket.requests = std::min(capacity_, bucket.requests + passed_seconds * rate_);
    bucket.at = now;
    if (bucket.requests < 1) return (1 - bucket.requests) / rate_;
    bucket.requests -= 1;
    return 0;
}

void RateLimiter::forget_full(Clock::time_point now) {
    std::erase_if(buckets_, [&](const auto& entry) {
        const double passed_seconds = std::chrono::duration<double>(now - entry.second.at).count();
        return entry.second.requests + passed_seconds * rate_ >= capacity_;
    });
    // All of them active: an attack by addresses; starting anew is kinder than growing without bound.
    if (buckets_.size() >= kMaxClients) buckets_.clear();
}

}  // namespace photond::http
