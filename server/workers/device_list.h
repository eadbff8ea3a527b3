#pragma once
// The devices of this machine, as a process of their own tells them: the daemon loads no driver.

#include <chrono>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace photond {

/// Thread-safe.
class DeviceList {
public:
    explicit DeviceList(std::filesystem::path worker_program) : worker_program_(std::move(worker_program)) {}

    /// Devices as on the wire (protocol.md, "Shapes"), the CPU first; each with its "lacks" and "limits". Starts the
    /// process when nobody has asked before, and waits for it: seconds at most. Empty when it failed, which is logged;
    /// it is tried again a minute later.
    std::vector<nlohmann::json> get();

    /// What `--devices` names as the devices there are: "gpu" is the first that can render. Asks the list only about
    /// GPUs. Throws ErrorCode::DeviceUnavailable for one that is not there or is named twice, ErrorCode::Unsupported,
    /// saying what is missing, for one that cannot render.
    std::vector<std::string> resolve(const std::vector<std::string>& names);

private:
    const std::filesystem::path worker_program_;
    std::mutex mutex_;
    std::vector<nlohmann::json> devices_;
    std::chrono::steady_clock::time_point retry_at_{};
};

}  // namespace photond
