#include "server/worker/core_share.h"

#include <utility>

#include "renderer/core/stats.h"

namespace photond {

namespace {

/// Adds what rose between two readings; where one of them is missing nothing is known of the whole.
void add(std::optional<double>& sum, const std::optional<double>& before, const std::optional<double>& now) {
    if (!sum || !before || !now)
        sum.reset();
    else
        *sum += *now - *before;
}

/// A thread that is new has waited since it began; so has one that was given the number of one that ended.
std::optional<double> waited(const CoreSample& before, const CoreSample& now) {
    if (!before.delays || !now.delays) return std::nullopt;
    double seconds = 0;
    for (const auto& [thread, delay] : *now.delays) {
        const auto earlier = before.delays->find(thread);
        const bool same = earlier != before.delays->end() && earlier->second <= delay;
        seconds += same ? delay - earlier->second : delay;
    }
    return seconds;
}

}  // namespace

CoreSample core_sample_now() { return {cpu_now_seconds(), run_delays(), host_time(), pressure_seconds()}; }

void CoreShare::begin() {
    sums_ = CoreUse::of_nothing();
    state_ = State::Paused;
    resume();
}

void CoreShare::pause() {
    look();
    if (state_ == State::Running) state_ = State::Paused;
}

void CoreShare::resume() {
    if (state_ != State::Paused) return;
    last_ = sample_();
    state_ = State::Running;
}

void CoreShare::end() {
    look();
    state_ = State::Idle;
}

void CoreShare::look() {
    if (state_ != State::Running) return;
    const CoreSample before = std::exchange(last_, sample_());
    const double own = last_.process_seconds - before.process_seconds;
    sums_.processor_seconds += own;
    add(sums_.run_delay_seconds, 0.0, waited(before, last_));
    const auto of_host = [](const CoreSample& sample, double HostTime::*what) {
        return sample.host ? std::optional((*sample.host).*what) : std::nullopt;
    };
    add(sums_.host_busy_outside_seconds, of_host(before, &HostTime::busy_seconds),
        of_host(last_, &HostTime::busy_seconds));
    add(sums_.host_busy_outside_seconds, own, 0.0);
    add(sums_.host_steal_seconds, of_host(before, &HostTime::steal_seconds), of_host(last_, &HostTime::steal_seconds));
    add(sums_.pressure_seconds, before.pressure_seconds, last_.pressure_seconds);
}

}  // namespace photond
