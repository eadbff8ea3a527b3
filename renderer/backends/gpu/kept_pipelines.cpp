#include "renderer/backends/gpu/kept_pipelines.h"

#include "renderer/backends/gpu/device.h"

namespace photond::gpu {

SharedPipeline KeptPipelines::get(const std::string& key, const std::function<VkPipeline()>& compile) {
    if (const auto found = by_key_.find(key); found != by_key_.end()) {
        kept_.splice(kept_.begin(), kept_, found->second);
        return kept_.front().pipeline;
    }
    const Device& device = device_;
    SharedPipeline pipeline(
        compile(), [&device](VkPipeline handle) { device.vk().vkDestroyPipeline(device.handle(), handle, nullptr); });
    kept_.push_front({key, pipeline});
    by_key_.emplace(key, kept_.begin());
    if (kept_.size() > kMost) {
        by_key_.erase(kept_.back().key);
        kept_.pop_back();
    }
    return pipeline;
}

}  // namespace photond::gpu
