#include "server/workers/device_list.h"

#include <signal.h>
#include <spdlog/spdlog.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "protocol/error.h"
#include "protocol/message_channel.h"
#include "protocol/worker_messages.h"
#include "server/workers/spawn.h"

namespace photond {

using nlohmann::json;

namespace {

constexpr int kPatienceMs = 20'000;  // drivers of several cards take seconds to wake
constexpr std::chrono::seconds kRetry{60};

/// One process from its start to its end.
std::vector<json> ask(const std::filesystem::path& program) {
    const Child child = spawn_child(program, {"--device", "list"}, {});
    std::optional<json> message;
    {
        MessageChannel channel(child.socket);
        message = channel.receive(kPatienceMs);
    }
    kill(child.pid, SIGKILL);  // it has said all it knows, or never will
    close(child.socket);
    while (waitpid(child.pid, nullptr, 0) < 0 && errno == EINTR) {
    }
    auto devices = message ? message_as<DevicesMessage>(*message) : std::nullopt;
    if (!devices) throw Error(ErrorCode::Internal, "the process that lists devices told none");
    return std::move(devices->items);
}

std::string listed(const json& words) {
    std::string text;
    for (const json& word : words) text += (text.empty() ? "" : ", ") + word.get<std::string>();
    return text;
}

}  // namespace

std::vector<json> DeviceList::get() {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (!devices_.empty() || now < retry_at_) return devices_;
    try {
        devices_ = ask(worker_program_);
    } catch (const std::exception& error) {
        spdlog::warn("the devices of this machine are not known: {}", error.what());
        retry_at_ = now + kRetry;
    }
    return devices_;
}

std::vector<std::string> DeviceList::resolve(const std::vector<std::string>& names) {
    std::vector<std::string> ids;
    for (const std::string& name : names) {
        std::string id = name;
        if (name != "cpu") {
            if (!name.starts_with("gpu"))
                throw Error(ErrorCode::DeviceUnavailable,
                            "device '" + name + "' is unavailable: devices are cpu, gpu and gpu:N");
            const std::vector<json> all = get();
            const auto is_wanted = [&](const json& device) {
                return device.at("id") == name ||
                       (name == "gpu" && device.at("kind") == "gpu" && device.at("lacks").empty());
            };
            const auto found = std::find_if(all.begin(), all.end(), is_wanted);
            if (found == all.end()) {
                std::string known;
                for (const json& device : all) {
                    if (!known.empty()) known += ", ";
                    known += device.at("id").get<std::string>();
                    known.append(" (").append(device.at("name").get<std::string>());
                    if (!device.at("lacks").empty()) known.append(", lacks ").append(listed(device.at("lacks")));
                    known += ")";
                }
                throw Error(
                    ErrorCode::DeviceUnavailable,
                    std::string("device '").append(name).append("' is unavailable; this machine has: ") + known);
            }
            id = found->at("id").get<std::string>();
            if (!found->at("lacks").empty())
                throw Error(ErrorCode::Unsupported, "device " + id + " (" + found->at("name").get<std::string>() +
                                                        ") cannot render: it lacks " + listed(found->at("lacks")));
        }
        if (std::find(ids.begin(), ids.end(), id) != ids.end())
            throw Error(ErrorCode::DeviceUnavailable, "device " + id + " is named twice: one worker holds a device");
        ids.push_back(id);
    }
    return ids;
}

}  // namespace photond
