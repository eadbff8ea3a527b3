#pragma once
// The devices a worker can be: what it says of itself in "hello" and in every statistics object.

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "renderer/backends/gpu/device_list.h"

namespace photond {

namespace gpu {
class Device;
}

struct Device {
    std::string id;    // "cpu", "gpu:0"; "none" for the helper
    std::string kind;  // "cpu", "gpu"
    std::string name;  // the processor's own
    uint64_t memory_bytes = 0;
    std::string driver = {};  // name and version; empty: it has none
    bool software = true;
    std::vector<std::string> lacks = {};            // what photond needs of a GPU and it has not
    std::optional<gpu::Limits> limits = {};         // of a GPU
    std::shared_ptr<gpu::Device> in_use = nullptr;  // a GPU that has been opened

    /// The device as on the wire (protocol.md, "Shapes"), with "lacks" and "limits".
    nlohmann::json to_json() const;
};

struct DeviceRequest {
    std::string id;                        // "cpu", "none", "gpu:N" or "gpu", the first that can render
    std::filesystem::path pipeline_cache;  // of a GPU (gpu::DeviceOptions)
    uint64_t memory_limit_bytes = 0;       // of the host
};

/// Opens a GPU, which loads its driver. Throws ErrorCode::DeviceUnavailable when there is no such device,
/// ErrorCode::Unsupported when it cannot render.
Device open_device(const DeviceRequest& request);

/// The CPU and all GPUs of this machine, none of them opened. Loads their drivers.
std::vector<Device> all_devices();

}  // namespace photond
