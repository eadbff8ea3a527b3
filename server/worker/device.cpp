#include "server/worker/device.h"

#include <fstream>

#include "protocol/error.h"
#include "server/worker/process_memory.h"

namespace photond {

namespace {

std::string processor_name() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);) {
        if (line.rfind("model name", 0) != 0) continue;
        const size_t colon = line.find(": ");
        if (colon != std::string::npos) return line.substr(colon + 2);
    }
    return "CPU";
}

}  // namespace

nlohmann::json Device::to_json() const {
    return {{"id", id},         {"kind", kind},    {"name", name}, {"driver", nullptr}, {"memory_bytes", memory_bytes},
            {"software", true}, {"state", "ready"}};
}

Device open_device(const std::string& id) {
    if (id == "cpu" || id == "none") return {id, "cpu", processor_name(), machine_memory_bytes()};
    throw Error(ErrorCode::DeviceUnavailable, "there is no device \"" + id + "\"; known: cpu, none");
}

}  // namespace photond
