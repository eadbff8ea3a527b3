#pragma once
// What Linux says of processor time: of the host's processors and of threads that wait for one. Parsers take the files'
// texts (proc(5)); they give nothing for what is not as it should be, and readers nothing where the kernel lacks it.

#include <sys/types.h>

#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace photond {

/// Of all processors of the host together, since it began.
struct HostTime {
    double busy_seconds = 0;   // in programs and in the kernel
    double steal_seconds = 0;  // taken by the machine that this one is a guest of
};

/// /proc/stat, whose figures are in ticks.
std::optional<HostTime> parse_host_time(std::string_view stat, double tick_seconds);
/// /proc/pressure/cpu: how long at least one thread of the host waited for a processor.
std::optional<double> parse_pressure_seconds(std::string_view pressure);
/// /proc/PID/task/TID/schedstat: how long a thread was ready to run and had no processor.
std::optional<double> parse_run_delay_seconds(std::string_view schedstat);

std::optional<HostTime> host_time();
std::optional<double> pressure_seconds();
/// Of this process, by the number of the thread.
std::optional<std::map<int, double>> run_delays();
/// Processor time that a process has taken since it began; nothing where there is none.
std::optional<double> processor_seconds_of(pid_t pid);

}  // namespace photond
