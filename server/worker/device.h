#pragma once
// The devices a worker can be: what it says of itself in "hello" and in every statistics object.

#include <nlohmann/json.hpp>
#include <string>

namespace photond {

struct Device {
    std::string id;    // "cpu"; "none" for the helper
    std::string kind;  // "cpu"
    std::string name;  // the processor's own
    uint64_t memory_bytes = 0;

    /// The device object of protocol.md.
    nlohmann::json to_json() const;
};

/// Throws ErrorCode::DeviceUnavailable when there is no such device in this build.
Device open_device(const std::string& id);

}  // namespace photond
