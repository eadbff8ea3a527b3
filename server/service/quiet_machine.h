#pragma once
// Whether nothing else runs on the host, for jobs whose clock is to be compared.

#include <chrono>
#include <deque>
#include <functional>
#include <optional>

namespace photond {

/// The host is quiet while at most this share of its processors is busy: what a job may lose and be undisturbed.
inline constexpr double kQuietLoad = 0.02;
/// It must have been quiet for this long before a job begins.
inline constexpr std::chrono::milliseconds kQuietFor{2000};

/// Looks at the host's processors while somebody asks.
class QuietMachine {
public:
    using Clock = std::chrono::steady_clock;

    /// `busy_seconds`: of all processors, rising; empty where the kernel does not say.
    QuietMachine(unsigned processors, std::function<std::optional<double>()> busy_seconds)
        : processors_(processors), busy_seconds_(std::move(busy_seconds)) {}
    QuietMachine();  // of this host

    /// The share of its processors that was busy for the last kQuietFor; empty while it has not been looked at for so
    /// long. 0 where the kernel does not say.
    std::optional<double> load(Clock::time_point now = Clock::now());

private:
    struct Look {
        Clock::time_point at;
        double busy_seconds;
    };
    const unsigned processors_;
    const std::function<std::optional<double>()> busy_seconds_;
    std::deque<Look> looks_;
};

}  // namespace photond
