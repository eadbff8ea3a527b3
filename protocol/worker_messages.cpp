#include "protocol/worker_messages.h"

#include <algorithm>

namespace photond {

CoreUse CoreUse::of_nothing() {
    CoreUse nothing;
    nothing.run_delay_seconds = nothing.host_busy_outside_seconds = nothing.host_steal_seconds =
        nothing.pressure_seconds = 0.0;
    return nothing;
}

CoreUse& CoreUse::operator+=(const CoreUse& other) {
    processor_seconds += other.processor_seconds;
    const auto add = [](std::optional<double>& sum, const std::optional<double>& more) {
        sum = sum && more ? std::optional(*sum + *more) : std::nullopt;
    };
    add(run_delay_seconds, other.run_delay_seconds);
    add(host_busy_outside_seconds, other.host_busy_outside_seconds);
    add(host_steal_seconds, other.host_steal_seconds);
    add(pressure_seconds, other.pressure_seconds);
    return *this;
}

void CoreUse::derive(double clock_seconds, unsigned processors) {
    lost_seconds.reset(), share.reset(), clock_lost_seconds.reset();
    // It is counted in ticks, and ours exactly: the difference may be less than nothing.
    if (host_busy_outside_seconds) host_busy_outside_seconds = std::max(0.0, *host_busy_outside_seconds);
    if (!run_delay_seconds) return;
    // Threads that outnumber the processors wait for each other too. What others took of a thread's waiting is at most
    // what they ran meanwhile, and what they ran made nobody wait where a processor was idle: the smaller of the two.
    lost_seconds = std::max(0.0, *run_delay_seconds);
    if (host_busy_outside_seconds) lost_seconds = std::min(*host_busy_outside_seconds, *lost_seconds);
    // A job that waits for its GPU most of the time loses no more of its clock than its one thread had to wait.
    const double wanted = std::max(processor_seconds + *lost_seconds, clock_seconds);
    share = wanted > 0 ? 1 - std::min(1.0, *lost_seconds / wanted) : 1;
    // One thread that waits may keep all others waiting: a second is at most a second of the clock. And nobody is done
    // sooner than with all processors at work all the time.
    const double soonest = processor_seconds / std::max(processors, 1u);
    clock_lost_seconds = std::clamp(clock_seconds - soonest, 0.0, *lost_seconds);
}

std::optional<WorkerMessage> read_worker_message(const nlohmann::json& message) {
    return message_among(message, std::type_identity<WorkerMessage>());
}

std::optional<DaemonMessage> read_daemon_message(const nlohmann::json& message) {
    return message_among(message, std::type_identity<DaemonMessage>());
}

}  // namespace photond
