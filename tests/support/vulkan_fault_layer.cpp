// A Vulkan layer that makes one call fail, so that tests see what photond makes of it. Loaded like any explicit layer
// (VK_LAYER_PATH, VK_INSTANCE_LAYERS=VK_LAYER_PHOTOND_fault); what it does is in the environment:
//   PHOTOND_FAULT_CALL    vkQueueSubmit2, vkWaitSemaphores, vkAllocateMemory or vkCreateComputePipelines
//   PHOTOND_FAULT_AT      which of a process' calls fails: 1, 2, ...
//   PHOTOND_FAULT_RESULT  what it answers: "lost", "memory" or "failed"
//   PHOTOND_FAULT_ONCE    a file; the process that makes it is the only one with a fault. Absent: each has it
//   PHOTOND_FAULT_COUNTS  a file that each call of that name adds a line to
// A device that is lost stays lost: every later submission and wait of that process answers the same.

#include <fcntl.h>
#include <unistd.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

PFN_vkGetInstanceProcAddr g_next_instance_proc = nullptr;
PFN_vkGetDeviceProcAddr g_next_device_proc = nullptr;
PFN_vkQueueSubmit2 g_submit = nullptr;
PFN_vkWaitSemaphores g_wait = nullptr;
PFN_vkQueueWaitIdle g_queue_idle = nullptr;
PFN_vkDeviceWaitIdle g_device_idle = nullptr;
PFN_vkAllocateMemory g_allocate = nullptr;
PFN_vkCreateComputePipelines g_create_pipelines = nullptr;

std::atomic<unsigned> g_calls = 0;
std::atomic<bool> g_lost = false;

std::string setting(const char* name) {
    const char* value = std::getenv(name);
    return value ? value : "";
}

void add_line(const std::string& file, const char* call) {
    const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    if (descriptor < 0) return;
    char line[128];
    const int length = std::snprintf(line, sizeof line, "%d %s\n", static_cast<int>(getpid()), call);
    if (write(descriptor, line, static_cast<size_t>(length)) != length) std::abort();  // the test would count wrongly
    close(descriptor);
}

/// This process is the one that has the fault.
bool is_mine() {
    const std::string file = setting("PHOTOND_FAULT_ONCE");
    if (file.empty()) return true;
    const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (descriptor < 0) return false;
    close(descriptor);
    return true;
}

/// What a call is to answer in place of its own result: VK_SUCCESS lets it through.
VkResult fault_of(const char* call) {
    if (setting("PHOTOND_FAULT_CALL") != call) return VK_SUCCESS;
    if (const std::string counts = setting("PHOTOND_FAULT_COUNTS"); !counts.empty()) add_line(counts, call);
    const std::string at = setting("PHOTOND_FAULT_AT");
    if (at.empty() || ++g_calls != std::strtoul(at.c_str(), nullptr, 10) || !is_mine()) return VK_SUCCESS;
    const std::string result = setting("PHOTOND_FAULT_RESULT");
    if (result == "memory") return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    if (result == "failed") return VK_ERROR_INITIALIZATION_FAILED;
    g_lost = true;
    return VK_ERROR_DEVICE_LOST;
}

// A device that is lost works no more. Lavapipe's threads do, on memory that is about to be freed: they end first.

VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue queue, uint32_t count, const VkSubmitInfo2* submits, VkFence fence) {
    if (const VkResult fault = fault_of("vkQueueSubmit2")) {
        g_queue_idle(queue);
        return fault;
    }
    return g_lost ? VK_ERROR_DEVICE_LOST : g_submit(queue, count, submits, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL wait(VkDevice device, const VkSemaphoreWaitInfo* info, uint64_t timeout) {
    if (const VkResult fault = fault_of("vkWaitSemaphores")) {
        g_device_idle(device);
        return fault;
    }
    return g_lost ? VK_ERROR_DEVICE_LOST : g_wait(device, info, timeout);
}

VKAPI_ATTR VkResult VKAPI_CALL allocate(VkDevice device, const VkMemoryAllocateInfo* info,
                                        const VkAllocationCallbacks* callbacks, VkDeviceMemory* memory) {
    if (const VkResult fault = fault_of("vkAllocateMemory")) return fault;
    return g_allocate(device, info, callbacks, memory);
}

VKAPI_ATTR VkResult VKAPI_CALL create_pipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                                const VkComputePipelineCreateInfo* infos,
                                                const VkAllocationCallbacks* callbacks, VkPipeline* pipelines) {
    if (const VkResult fault = fault_of("vkCreateComputePipelines")) {
        for (uint32_t i = 0; i < count; ++i) pipelines[i] = VK_NULL_HANDLE;
        return fault;
    }
    return g_create_pipelines(device, cache, count, infos, callbacks, pipelines);
}

/// The loader's link to the layer below, taken out of what it chained to the create info.
template <class Link, class Info>
Link* next_link(const Info* info, VkStructureType type) {
    auto* link = static_cast<Link*>(const_cast<void*>(info->pNext));
    while (link && !(link->sType == type && link->function == VK_LAYER_LINK_INFO))
        link = static_cast<Link*>(const_cast<void*>(link->pNext));
    return link;
}

VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* callbacks,
                                               VkInstance* instance) {
    auto* link = next_link<VkLayerInstanceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    g_next_instance_proc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create =
        reinterpret_cast<PFN_vkCreateInstance>(g_next_instance_proc(VK_NULL_HANDLE, "vkCreateInstance"));
    return create ? create(info, callbacks, instance) : VK_ERROR_INITIALIZATION_FAILED;
}

VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                             const VkAllocationCallbacks* callbacks, VkDevice* device) {
    auto* link = next_link<VkLayerDeviceCreateInfo>(info, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    const PFN_vkGetInstanceProcAddr instance_proc = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    g_next_device_proc = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    const auto create = reinterpret_cast<PFN_vkCreateDevice>(instance_proc(VK_NULL_HANDLE, "vkCreateDevice"));
    const VkResult result = create(physical, info, callbacks, device);
    if (result != VK_SUCCESS) return result;
    const auto next = [&](const char* name) { return g_next_device_proc(*device, name); };
    g_submit = reinterpret_cast<PFN_vkQueueSubmit2>(next("vkQueueSubmit2"));
    g_wait = reinterpret_cast<PFN_vkWaitSemaphores>(next("vkWaitSemaphores"));
    g_queue_idle = reinterpret_cast<PFN_vkQueueWaitIdle>(next("vkQueueWaitIdle"));
    g_device_idle = reinterpret_cast<PFN_vkDeviceWaitIdle>(next("vkDeviceWaitIdle"));
    g_allocate = reinterpret_cast<PFN_vkAllocateMemory>(next("vkAllocateMemory"));
    g_create_pipelines = reinterpret_cast<PFN_vkCreateComputePipelines>(next("vkCreateComputePipelines"));
    return VK_SUCCESS;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL device_proc(VkDevice device, const char* name) {
    const auto is = [name](const char* ours) { return std::strcmp(name, ours) == 0; };
    if (is("vkGetDeviceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(device_proc);
    if (is("vkQueueSubmit2")) return reinterpret_cast<PFN_vkVoidFunction>(submit);
    if (is("vkWaitSemaphores")) return reinterpret_cast<PFN_vkVoidFunction>(wait);
    if (is("vkAllocateMemory")) return reinterpret_cast<PFN_vkVoidFunction>(allocate);
    if (is("vkCreateComputePipelines")) return reinterpret_cast<PFN_vkVoidFunction>(create_pipelines);
    return g_next_device_proc ? g_next_device_proc(device, name) : nullptr;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL instance_proc(VkInstance instance, const char* name) {
    const auto is = [name](const char* ours) { return std::strcmp(name, ours) == 0; };
    if (is("vkGetInstanceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(instance_proc);
    if (is("vkGetDeviceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(device_proc);
    if (is("vkCreateInstance")) return reinterpret_cast<PFN_vkVoidFunction>(create_instance);
    if (is("vkCreateDevice")) return reinterpret_cast<PFN_vkVoidFunction>(create_device);
    return g_next_instance_proc ? g_next_instance_proc(instance, name) : nullptr;
}

}  // namespace

extern "C" VK_LAYER_EXPORT VKAPI_ATTR VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
    version->loaderLayerInterfaceVersion = 2;
    version->pfnGetInstanceProcAddr = instance_proc;
    version->pfnGetDeviceProcAddr = device_proc;
    version->pfnGetPhysicalDeviceProcAddr = nullptr;
    return VK_SUCCESS;
}
