#pragma once
// Vulkan's instance: the way to the devices. One a process, made when first asked for.

#include <functional>
#include <vector>

#include "renderer/backends/gpu/device_list.h"
#include "renderer/backends/gpu/vulkan.h"

namespace photond::gpu {

/// A device as the instance knows it.
struct PhysicalDevice {
    VkPhysicalDevice handle;
    DeviceReport report;
};

class Instance {
public:
    /// nullptr where the machine has no Vulkan loader or no driver that is usable.
    static const Instance* get();

    VkInstance handle() const { return handle_; }
    bool debug_names() const { return debug_names_; }  // VK_EXT_debug_utils is there
    const std::vector<PhysicalDevice>& devices() const { return devices_; }

    /// Messages of the validation layers, which are on when PHOTOND_GPU_VALIDATION=1 is set: warnings and errors since
    /// the process began. Tests ask for zero. Where they are off, 0.
    static uint64_t validation_messages();
    static bool validation_enabled();

private:
    Instance() = default;
    bool create();

    VkInstance handle_ = VK_NULL_HANDLE;
    bool debug_names_ = false;
    std::vector<PhysicalDevice> devices_;
};

/// What is needed of a device, switched on when one is made: chained for vkGetPhysicalDeviceFeatures2 and VkDevice
/// alike.
struct Features {
    Features();
    Features(const Features&) = delete;
    Features& operator=(const Features&) = delete;

    VkPhysicalDeviceFeatures2 core{};
    VkPhysicalDeviceVulkan11Features v11{};
    VkPhysicalDeviceVulkan12Features v12{};
    VkPhysicalDeviceVulkan13Features v13{};
    VkPhysicalDeviceShaderAtomicFloatFeaturesEXT atomic_float{};

    /// Each feature photond needs: its name, and where it is told.
    void visit(const std::function<void(const char* name, VkBool32& value)>& visitor);
};

/// Extensions photond needs.
inline constexpr const char* kDeviceExtensions[] = {VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME};

}  // namespace photond::gpu
