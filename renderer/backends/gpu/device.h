#pragma once
// One device in use: its queue, its memory, its pipeline cache.

#include <atomic>
#include <filesystem>
#include <memory>
#include <span>

#include "renderer/backends/gpu/device_list.h"
#include "renderer/backends/gpu/kept_pipelines.h"
#include "renderer/backends/gpu/memory.h"

namespace photond::gpu {

struct DeviceOptions {
    std::string id = "gpu";                    // "gpu": the first that can render; "gpu:N": that one
    std::filesystem::path pipeline_cache;      // file that compiled pipelines are kept in; empty: none
    uint64_t memory_limit_bytes = UINT64_MAX;  // of all structures together; the device's own memory if that is less
};

/// Everything else in this folder borrows its Device. Work is submitted in order to one queue; the host waits for
/// points of its timeline.
class Device {
public:
    /// Throws ErrorCode::DeviceUnavailable when there is none of that id, ErrorCode::Unsupported, naming what is
    /// missing, when it lacks what photond needs.
    explicit Device(const DeviceOptions& options);
    /// Saves the pipeline cache, if it can.
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const DeviceReport& report() const { return report_; }
    const Limits& limits() const { return report_.limits; }
    VkDevice handle() const { return handle_; }
    VkPhysicalDevice physical() const { return physical_; }
    const VolkDeviceTable& vk() const { return vk_; }
    uint32_t queue_family() const { return queue_family_; }
    VkPipelineCache pipeline_cache() const { return pipeline_cache_; }
    KeptPipelines& pipelines() { return pipelines_; }
    Memory& memory() { return *memory_; }
    uint64_t memory_limit_bytes() const { return memory_limit_bytes_; }

    /// Throws ErrorCode::OutOfMemory, with both figures, when `bytes` more for a structure would pass the limit.
    void require(const std::string& structure, uint64_t bytes) const;

    /// Names a Vulkan object in validation messages and captures.
    void set_name(VkObjectType type, uint64_t object, const std::string& name) const;

    /// Starts recorded commands after all that were submitted before; the point of the timeline at which they are done.
    uint64_t submit(VkCommandBuffer commands);
    /// Commands that were recorded will not be submitted, nor the barriers that later ones count on: what is submitted
    /// next waits for all before it.
    void drop_barriers() { barriers_dropped_ = true; }
    /// Blocks until that point is reached. Throws DeviceLost.
    void wait(uint64_t point);
    bool reached(uint64_t point);
    void wait_idle() { wait(submitted_); }

    /// Writes the pipeline cache's file where the cache has grown since. What fails is left for the next time.
    void save_pipeline_cache() noexcept;

    /// Paths one submission should hold at most, so that cancelling is answered soon: a software device takes seconds
    /// for what a card does in a millisecond.
    uint32_t paths_per_submit() const { return report_.software ? 1u << 15 : kMostPathsPerSubmit; }
    static constexpr uint32_t kMostPathsPerSubmit = 1u << 24;

private:
    void make_device(VkPhysicalDevice physical);
    void close() noexcept;
    void load_pipeline_cache(const std::filesystem::path& file);

    DeviceReport report_;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice handle_ = VK_NULL_HANDLE;
    VolkDeviceTable vk_{};
    uint32_t queue_family_ = 0;
    VkQueue queue_ = VK_NULL_HANDLE;
    VkSemaphore timeline_ = VK_NULL_HANDLE;
    uint64_t submitted_ = 0;
    bool barriers_dropped_ = false;
    std::filesystem::path cache_file_;
    VkPipelineCache pipeline_cache_ = VK_NULL_HANDLE;
    size_t saved_cache_bytes_ = 0;
    KeptPipelines pipelines_{*this};
    std::unique_ptr<Memory> memory_;
    uint64_t memory_limit_bytes_;
};

}  // namespace photond::gpu
