#include "renderer/backends/gpu/instance.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace photond::gpu {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";
std::atomic<uint64_t> g_validation_messages = 0;

VKAPI_ATTR VkBool32 VKAPI_CALL count_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                             VkDebugUtilsMessageTypeFlagsEXT type,
                                             const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
    if (type & (VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT)) {
        g_validation_messages.fetch_add(1, std::memory_order_relaxed);
        std::fprintf(stderr, "photond: Vulkan validation: %s\n", data->pMessage);
    }
    return VK_FALSE;
}

Limits limits_of(VkPhysicalDevice device) {
    VkPhysicalDeviceVulkan12Properties v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES};
    VkPhysicalDeviceVulkan11Properties v11{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES, &v12};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &v11};
    vkGetPhysicalDeviceProperties2(device, &properties);
    const VkPhysicalDeviceLimits& vk = properties.properties.limits;
    Limits limits;
    limits.storage_buffer_range = vk.maxStorageBufferRange;
    limits.allocation = v11.maxMemoryAllocationSize;
    limits.storage_buffers = std::min(vk.maxPerStageDescriptorStorageBuffers, vk.maxDescriptorSetStorageBuffers);
    limits.push_constants = vk.maxPushConstantsSize;
    limits.shared_memory = vk.maxComputeSharedMemorySize;
    limits.workgroup_size = std::min(vk.maxComputeWorkGroupInvocations, vk.maxComputeWorkGroupSize[0]);
    for (int i = 0; i < 3; ++i) limits.workgroups[i] = vk.maxComputeWorkGroupCount[i];
    limits.subgroup_size = v11.subgroupSize;
    limits.keeps_infinities = v12.shaderSignedZeroInfNanPreserveFloat32 == VK_TRUE;
    limits.image_side = vk.maxImageDimension2D;
    limits.timestamp_seconds = vk.timestampComputeAndGraphics ? 1e-9 * double{vk.timestampPeriod} : 0.0;
    return limits;
}

std::vector<std::string> lacking(VkPhysicalDevice device, const VkPhysicalDeviceProperties& properties) {
    std::vector<std::string> lacks;
    if (properties.apiVersion < VK_API_VERSION_1_3) {
        lacks.emplace_back("Vulkan 1.3");
        return lacks;  // the structures of 1.3 would not be filled in
    }
    uint32_t count = 0;
    vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> extensions(count);
    vkEnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data());
    for (const char* wanted : kDeviceExtensions)
        if (std::none_of(extensions.begin(), extensions.end(),
                         [&](const auto& e) { return std::strcmp(e.extensionName, wanted) == 0; }))
            lacks.emplace_back(wanted);
    Features features;
    vkGetPhysicalDeviceFeatures2(device, &features.core);
    features.visit([&](const char* name, VkBool32& value) {
        if (!value) lacks.emplace_back(name);
    });
    return lacks;
}

DeviceReport report_on(VkPhysicalDevice device) {
    VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
    vkGetPhysicalDeviceProperties2(device, &properties);
    DeviceReport report;
    report.name = properties.properties.deviceName;
    report.driver = std::string(driver.driverName) + " " + driver.driverInfo;
    report.software = properties.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(device, &memory);
    for (uint32_t i = 0; i < memory.memoryHeapCount; ++i)
        if (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
            report.memory_bytes = std::max(report.memory_bytes, memory.memoryHeaps[i].size);
    report.limits = limits_of(device);
    report.lacks = lacking(device, properties.properties);
    return report;
}

}  // namespace

Features::Features() {
    core.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    v11.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES;
    v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    core.pNext = &v11, v11.pNext = &v12, v12.pNext = &v13;
}

void Features::visit(const std::function<void(const char*, VkBool32&)>& visitor) {
    visitor("shaderInt64", core.features.shaderInt64);
    visitor("shaderClipDistance", core.features.shaderClipDistance);
    visitor("independentBlend", core.features.independentBlend);
    visitor("fragmentStoresAndAtomics", core.features.fragmentStoresAndAtomics);
    visitor("scalarBlockLayout", v12.scalarBlockLayout);
    visitor("timelineSemaphore", v12.timelineSemaphore);
    visitor("hostQueryReset", v12.hostQueryReset);
    visitor("synchronization2", v13.synchronization2);
    visitor("dynamicRendering", v13.dynamicRendering);
    visitor("maintenance4", v13.maintenance4);
}

const Instance* Instance::get() {
    static const std::unique_ptr<const Instance> kInstance = [] {
        std::unique_ptr<Instance> instance(new Instance);
        return instance->create() ? std::move(instance) : nullptr;
    }();
    return kInstance.get();
}

bool Instance::validation_enabled() {
    const char* wanted = std::getenv("PHOTOND_GPU_VALIDATION");
    return wanted && std::strcmp(wanted, "1") == 0;
}

uint64_t Instance::validation_messages() { return g_validation_messages; }

bool Instance::create() {
    if (volkInitialize() != VK_SUCCESS || volkGetInstanceVersion() < VK_API_VERSION_1_3) return false;
    uint32_t count = 0;
    vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> available(count);
    vkEnumerateInstanceExtensionProperties(nullptr, &count, available.data());
    debug_names_ = std::any_of(available.begin(), available.end(), [](const auto& e) {
        return std::strcmp(e.extensionName, VK_EXT_DEBUG_UTILS_EXTENSION_NAME) == 0;
    });

    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.pApplicationName = "photond";
    application.apiVersion = VK_API_VERSION_1_3;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    std::vector<const char*> extensions, layers;
    if (debug_names_) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);

    VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType =
        VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
    messenger.pfnUserCallback = count_message;
    const VkValidationFeatureEnableEXT synchronisation = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger};
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &synchronisation;
    const bool validate = validation_enabled();
    if (validate) {
        layers.push_back(kValidationLayer);
        extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
        info.pNext = &features;
    }
    info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    info.enabledLayerCount = static_cast<uint32_t>(layers.size());
    info.ppEnabledLayerNames = layers.data();
    const VkResult result = vkCreateInstance(&info, nullptr, &handle_);
    if (validate)
        check(result, "making a Vulkan instance with validation layers");  // asked for: never left out silently
    if (result != VK_SUCCESS) return false;
    volkLoadInstanceOnly(handle_);
    if (validate) {
        VkDebugUtilsMessengerEXT unused;
        check(vkCreateDebugUtilsMessengerEXT(handle_, &messenger, nullptr, &unused),
              "listening to the validation layers");
    }

    count = 0;
    vkEnumeratePhysicalDevices(handle_, &count, nullptr);
    std::vector<VkPhysicalDevice> handles(count);
    vkEnumeratePhysicalDevices(handle_, &count, handles.data());
    for (uint32_t i = 0; i < count; ++i) devices_.push_back({handles[i], report_on(handles[i])});
    std::stable_sort(devices_.begin(), devices_.end(),
                     [](const auto& a, const auto& b) { return a.report.software < b.report.software; });
    for (size_t i = 0; i < devices_.size(); ++i) devices_[i].report.id = "gpu:" + std::to_string(i);
    return true;
}

std::vector<DeviceReport> list_devices() {
    std::vector<DeviceReport> reports;
    if (const Instance* instance = Instance::get())
        for (const PhysicalDevice& device : instance->devices()) reports.push_back(device.report);
    return reports;
}

}  // namespace photond::gpu
