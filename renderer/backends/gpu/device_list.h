#pragma once
// Which Vulkan devices this machine has, and what they can do.

#include <cstdint>
#include <string>
#include <vector>

namespace photond::gpu {

/// What photond asks a device for. Sizes in bytes.
struct Limits {
    uint64_t storage_buffer_range = 0;  // of one buffer as a shader sees it
    uint64_t allocation = 0;            // of one block of memory
    uint32_t storage_buffers = 0;       // of one shader
    uint32_t push_constants = 0;
    uint32_t shared_memory = 0;  // of a workgroup
    uint32_t workgroup_size = 0;
    uint32_t workgroups[3]{};  // of one dispatch
    uint32_t subgroup_size = 0;
    bool keeps_infinities = false;  // shaders can ask for IEEE 754's infinities, NaN and signs of 0 in 32 bits
    uint32_t image_side = 0;
    double timestamp_seconds = 0;  // of one tick; 0: no timestamps
};

/// One physical device.
struct DeviceReport {
    std::string id;      // "gpu:0"; real cards are numbered before software ones
    std::string name;    // "NVIDIA H200"
    std::string driver;  // name and version
    bool software = false;
    uint64_t memory_bytes = 0;  // of the device-local heap
    Limits limits;
    std::vector<std::string> lacks;  // features photond needs and it has not; empty: it can render
};

/// All of them; empty where there is no Vulkan. Loads drivers: in a worker, never in the daemon.
std::vector<DeviceReport> list_devices();

}  // namespace photond::gpu
