#include "server/processor_time.h"

#include <dirent.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <vector>

namespace photond {

namespace {

/// The numbers that a text begins with, spaces between them.
std::vector<uint64_t> numbers_of(std::string_view text) {
    std::vector<uint64_t> numbers;
    const char *at = text.data(), *const end = text.data() + text.size();
    while (true) {
        while (at != end && *at == ' ') ++at;
        uint64_t number = 0;
        const auto [stopped, error] = std::from_chars(at, end, number);
        if (error != std::errc()) return numbers;
        numbers.push_back(number);
        at = stopped;
    }
}

/// The beginning of a file of the kernel's. Not by streams: threads are many, and each has a file.
std::optional<std::string> beginning_of(const char* path) {
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return std::nullopt;
    std::array<char, 512> text;
    const ssize_t length = read(file, text.data(), text.size());
    close(file);
    if (length <= 0) return std::nullopt;
    return std::string(text.data(), static_cast<size_t>(length));
}

}  // namespace

std::optional<HostTime> parse_host_time(std::string_view stat, double tick_seconds) {
    constexpr std::string_view kAll = "cpu ";
    enum Column { kUser, kNice, kSystem, kIdle, kWaiting, kInterrupts, kSoftInterrupts, kSteal, kColumns };
    if (!stat.starts_with(kAll)) return std::nullopt;
    const std::vector<uint64_t> ticks = numbers_of(stat.substr(kAll.size()));
    if (ticks.size() < kColumns) return std::nullopt;
    const uint64_t busy = ticks[kUser] + ticks[kNice] + ticks[kSystem] + ticks[kInterrupts] + ticks[kSoftInterrupts];
    return HostTime{static_cast<double>(busy) * tick_seconds, static_cast<double>(ticks[kSteal]) * tick_seconds};
}

std::optional<double> parse_pressure_seconds(std::string_view pressure) {
    constexpr std::string_view kTotal = " total=";
    const std::string_view some = pressure.substr(0, pressure.find('\n'));
    const size_t found = some.find(kTotal);
    if (!some.starts_with("some ") || found == std::string_view::npos) return std::nullopt;
    const std::vector<uint64_t> microseconds = numbers_of(some.substr(found + kTotal.size()));
    if (microseconds.empty()) return std::nullopt;
    return static_cast<double>(microseconds.front()) * 1e-6;
}

std::optional<double> parse_run_delay_seconds(std::string_view schedstat) {
    const std::vector<uint64_t> numbers = numbers_of(schedstat);  // run [ns], delay [ns], slices
    if (numbers.size() < 3) return std::nullopt;
    return static_cast<double>(numbers[1]) * 1e-9;
}

std::optional<HostTime> host_time() {
    const auto stat = beginning_of("/proc/stat");
    return stat ? parse_host_time(*stat, 1.0 / static_cast<double>(sysconf(_SC_CLK_TCK))) : std::nullopt;
}

std::optional<double> pressure_seconds() {
    const auto pressure = beginning_of("/proc/pressure/cpu");
    return pressure ? parse_pressure_seconds(*pressure) : std::nullopt;
}

std::optional<std::map<int, double>> run_delays() {
    const std::unique_ptr<DIR, int (*)(DIR*)> tasks(opendir("/proc/self/task"), &closedir);
    if (!tasks) return std::nullopt;
    std::map<int, double> delays;
    while (const dirent* task = readdir(tasks.get())) {
        const int thread = std::atoi(task->d_name);
        if (thread <= 0) continue;  // the folder itself and the one above
        const auto schedstat = beginning_of(("/proc/self/task/" + std::to_string(thread) + "/schedstat").c_str());
        if (!schedstat) continue;  // it has just ended
        if (const auto delay = parse_run_delay_seconds(*schedstat)) delays[thread] = *delay;
    }
    if (delays.empty()) return std::nullopt;  // the kernel does not say
    return delays;
}

std::optional<double> processor_seconds_of(pid_t pid) {
    clockid_t clock{};
    timespec time{};
    if (pid <= 0 || clock_getcpuclockid(pid, &clock) != 0 || clock_gettime(clock, &time) != 0) return std::nullopt;
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace photond
