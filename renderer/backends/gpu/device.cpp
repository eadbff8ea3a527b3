#include "renderer/backends/gpu/device.h"

#include <algorithm>
#include <fstream>

#include "renderer/backends/gpu/instance.h"
#include "renderer/core/atomic_file.h"

namespace photond::gpu {

namespace {

const PhysicalDevice& find_device(const std::string& id) {
    const Instance* instance = Instance::get();
    if (!instance || instance->devices().empty())
        throw Error(ErrorCode::DeviceUnavailable, "this machine has no Vulkan driver");
    const std::vector<PhysicalDevice>& devices = instance->devices();
    if (id == "gpu") {
        for (const PhysicalDevice& device : devices)
            if (device.report.lacks.empty()) return device;
        return devices.front();  // whose lacks are told
    }
    for (const PhysicalDevice& device : devices)
        if (device.report.id == id) return device;
    throw Error(ErrorCode::DeviceUnavailable,
                "there is no device " + id + "; the last one is " + devices.back().report.id);
}

/// A family that can do everything, as every driver's first does.
uint32_t find_queue_family(VkPhysicalDevice physical) {
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    constexpr VkQueueFlags kAll = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    for (uint32_t i = 0; i < count; ++i)
        if ((families[i].queueFlags & kAll) == kAll) return i;
    throw Error(ErrorCode::Unsupported, "the GPU has no queue for both compute and raster");
}

}  // namespace

Device::Device(const DeviceOptions& options) : cache_file_(options.pipeline_cache) {
    const PhysicalDevice& physical = find_device(options.id);
    report_ = physical.report;
    physical_ = physical.handle;
    if (!report_.lacks.empty()) {
        std::string list;
        for (const std::string& lack : report_.lacks) list += (list.empty() ? "" : ", ") + lack;
        throw Error(ErrorCode::Unsupported, report_.id + " (" + report_.name + ") lacks " + list);
    }
    memory_limit_bytes_ = std::min(options.memory_limit_bytes, report_.memory_bytes);
    try {
        make_device(physical.handle);
        memory_ = std::make_unique<Memory>(physical.handle, handle_, vk_, report_.software);
        load_pipeline_cache(cache_file_);
    } catch (...) {
        close();
        throw;
    }
}

void Device::make_device(VkPhysicalDevice physical) {
    queue_family_ = find_queue_family(physical);
    const float priority = 1;
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueFamilyIndex = queue_family_;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    Features features;
    features.visit([](const char*, VkBool32& value) { value = VK_TRUE; });
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features.core};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = static_cast<uint32_t>(std::size(kDeviceExtensions));
    info.ppEnabledExtensionNames = kDeviceExtensions;
    check(vkCreateDevice(physical, &info, nullptr, &handle_), "opening " + report_.id);
    volkLoadDeviceTable(&vk_, handle_);
    vk_.vkGetDeviceQueue(handle_, queue_family_, 0, &queue_);

    VkSemaphoreTypeCreateInfo timeline{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO};
    timeline.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    const VkSemaphoreCreateInfo semaphore{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &timeline};
    check(vk_.vkCreateSemaphore(handle_, &semaphore, nullptr, &timeline_), "making a timeline");
}

Device::~Device() {
    vk_.vkDeviceWaitIdle(handle_);  // lost or not: nothing more can be done here
    save_pipeline_cache();
    close();
}

void Device::close() noexcept {
    if (!handle_) return;
    pipelines_.clear();
    vk_.vkDestroyPipelineCache(handle_, pipeline_cache_, nullptr);
    vk_.vkDestroySemaphore(handle_, timeline_, nullptr);
    memory_.reset();
    vk_.vkDestroyDevice(handle_, nullptr);
}

/// What another driver wrote, the driver itself refuses by the header it begins with.
void Device::load_pipeline_cache(const std::filesystem::path& file) {
    std::vector<char> bytes;
    if (std::ifstream in(file, std::ios::binary); !file.empty() && in)
        bytes.assign(std::istreambuf_iterator<char>(in), {});
    VkPipelineCacheCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
    info.initialDataSize = bytes.size();
    info.pInitialData = bytes.data();
    check(vk_.vkCreatePipelineCache(handle_, &info, nullptr, &pipeline_cache_), "making the pipeline cache");
    saved_cache_bytes_ = bytes.size();
}

void Device::save_pipeline_cache() noexcept try {
    if (cache_file_.empty()) return;
    size_t size = 0;
    if (vk_.vkGetPipelineCacheData(handle_, pipeline_cache_, &size, nullptr) != VK_SUCCESS) return;
    if (size == saved_cache_bytes_) return;
    std::vector<char> bytes(size);
    if (vk_.vkGetPipelineCacheData(handle_, pipeline_cache_, &size, bytes.data()) != VK_SUCCESS) return;
    AtomicFile file(cache_file_);
    file.write(bytes.data(), size);
    file.commit();
    saved_cache_bytes_ = size;
} catch (const std::exception&) {
    return;  // the next start compiles again
}

void Device::require(const std::string& structure, uint64_t bytes) const {
    const uint64_t held = memory_->used_bytes();
    if (bytes <= memory_limit_bytes_ && held <= memory_limit_bytes_ - bytes) return;
    throw Error(ErrorCode::OutOfMemory, structure + " needs " + std::to_string(bytes) + " bytes of " + report_.id +
                                            " beside the " + std::to_string(held) + " in use; the limit is " +
                                            std::to_string(memory_limit_bytes_) + " bytes");
}

void Device::set_name(VkObjectType type, uint64_t object, const std::string& name) const {
    if (!Instance::get()->debug_names()) return;
    VkDebugUtilsObjectNameInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT};
    info.objectType = type;
    info.objectHandle = object;
    info.pObjectName = name.c_str();
    vkSetDebugUtilsObjectNameEXT(handle_, &info);
}

uint64_t Device::submit(VkCommandBuffer commands) {
    VkCommandBufferSubmitInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
    buffer.commandBuffer = commands;
    VkSemaphoreSubmitInfo signal{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO};
    signal.semaphore = timeline_;
    signal.value = submitted_ + 1;
    signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    VkSubmitInfo2 info{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
    info.commandBufferInfoCount = 1;
    info.pCommandBufferInfos = &buffer;
    info.signalSemaphoreInfoCount = 1;
    info.pSignalSemaphoreInfos = &signal;
    VkSemaphoreSubmitInfo before = signal;
    before.value = submitted_;
    if (barriers_dropped_) {
        info.waitSemaphoreInfoCount = 1;
        info.pWaitSemaphoreInfos = &before;
    }
    check(vk_.vkQueueSubmit2(queue_, 1, &info, VK_NULL_HANDLE), "submitting work");
    barriers_dropped_ = false;
    return ++submitted_;
}

void Device::wait(uint64_t point) {
    VkSemaphoreWaitInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO};
    info.semaphoreCount = 1;
    info.pSemaphores = &timeline_;
    info.pValues = &point;
    check(vk_.vkWaitSemaphores(handle_, &info, UINT64_MAX), "waiting for work");
}

bool Device::reached(uint64_t point) {
    uint64_t value = 0;
    check(vk_.vkGetSemaphoreCounterValue(handle_, timeline_, &value), "asking how far work is");
    return value >= point;
}

}  // namespace photond::gpu
