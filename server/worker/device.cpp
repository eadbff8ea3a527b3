#include "server/worker/device.h"

#include <fstream>

#include "protocol/error.h"
#include "renderer/backends/gpu/device.h"
#include "server/device_memory.h"
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

Device reported(const gpu::DeviceReport& report) {
    return {report.id,    "gpu",         report.name, report.memory_bytes, report.driver, report.software,
            report.lacks, report.limits, nullptr};
}

}  // namespace

nlohmann::json Device::to_json() const {
    nlohmann::json limit_values;
    if (limits)
        limit_values = {{"storage_buffer_bytes", limits->storage_buffer_range},
                        {"allocation_bytes", limits->allocation},
                        {"storage_buffers", limits->storage_buffers},
                        {"push_constant_bytes", limits->push_constants},
                        {"shared_memory_bytes", limits->shared_memory},
                        {"workgroup_size", limits->workgroup_size},
                        {"workgroups", {limits->workgroups[0], limits->workgroups[1], limits->workgroups[2]}},
                        {"subgroup_size", limits->subgroup_size},
                        {"image_side", limits->image_side},
                        {"timestamp_seconds", limits->timestamp_seconds}};
    return {{"id", id},
            {"kind", kind},
            {"name", name},
            {"driver", driver.empty() ? nlohmann::json() : nlohmann::json(driver)},
            {"memory_bytes", memory_bytes},
            {"software", software},
            {"state", lacks.empty() ? "ready" : "failed"},
            {"lacks", lacks},
            {"limits", limit_values}};
}

Device open_device(const DeviceRequest& request) {
    if (request.id == "cpu" || request.id == "none")
        return {request.id, "cpu", processor_name(), machine_memory_bytes()};
    if (!request.id.starts_with("gpu"))
        throw Error(ErrorCode::DeviceUnavailable,
                    "there is no device \"" + request.id + "\"; known: cpu, gpu, gpu:N, none");
    for (const gpu::DeviceReport& report : gpu::list_devices()) {
        if (report.id != request.id && !(request.id == "gpu" && report.lacks.empty())) continue;
        Device device = reported(report);
        device.in_use = std::make_shared<gpu::Device>(
            gpu::DeviceOptions{report.id, request.pipeline_cache,
                               device_limit_bytes(report.memory_bytes, report.software, request.memory_limit_bytes)});
        return device;
    }
    throw Error(ErrorCode::DeviceUnavailable, "this machine has no device " + request.id + " that can render");
}

std::vector<Device> all_devices() {
    std::vector<Device> devices{{"cpu", "cpu", processor_name(), machine_memory_bytes()}};
    for (const gpu::DeviceReport& report : gpu::list_devices()) devices.push_back(reported(report));
    return devices;
}

}  // namespace photond
