#pragma once
// Vulkan's C API, its functions found at run time (volk): a machine without Vulkan starts the same programs.

#include <string>
#define VK_NO_PROTOTYPES
#include <volk.h>

#include "protocol/error.h"

namespace photond::gpu {

/// The device stopped answering: nothing it held can be trusted, and this process cannot get it back. What a worker
/// does with it: end, so that a new process tries once more.
class DeviceLost : public Error {
public:
    explicit DeviceLost(const std::string& doing);
};

/// "VK_ERROR_DEVICE_LOST".
std::string result_name(VkResult result);

/// Throws on every result that is not a success, saying what was being done: DeviceLost; ErrorCode::OutOfMemory for
/// host and device memory; ErrorCode::Unsupported for a missing feature, layer, extension or driver; else Internal.
void check(VkResult result, const std::string& doing);

}  // namespace photond::gpu
