#include "server/service/quiet_machine.h"

#include <algorithm>
#include <thread>

#include "server/processor_time.h"

namespace photond {

namespace {

constexpr std::chrono::milliseconds kBetweenLooks{100};

std::optional<double> host_busy_seconds() {
    const auto time = host_time();
    return time ? std::optional(time->busy_seconds) : std::nullopt;
}

}  // namespace

QuietMachine::QuietMachine() : QuietMachine(std::thread::hardware_concurrency(), host_busy_seconds) {}

std::optional<double> QuietMachine::load(Clock::time_point now) {
    const auto busy = busy_seconds_();
    if (!busy) return 0;
    // Nobody has asked for a while: what was then is too old to go on from.
    if (!looks_.empty() && now - looks_.back().at > kQuietFor) looks_.clear();
    if (looks_.empty() || now - looks_.back().at >= kBetweenLooks) looks_.push_back({now, *busy});
    while (looks_.size() > 1 && now - looks_[1].at >= kQuietFor) looks_.pop_front();
    const std::chrono::duration<double> watched = looks_.back().at - looks_.front().at;
    if (watched < kQuietFor) return std::nullopt;
    return std::max(0.0, looks_.back().busy_seconds - looks_.front().busy_seconds) /
           (watched.count() * std::max(processors_, 1u));
}

}  // namespace photond
