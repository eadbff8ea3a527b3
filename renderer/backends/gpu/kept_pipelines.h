#pragma once
// Compiled pipelines that stay with their device when nobody uses them: the next job of a worker asks for the same
// ones.

#include <functional>
#include <list>
#include <memory>
#include <string>
#include <unordered_map>

#include "renderer/backends/gpu/vulkan.h"

namespace photond::gpu {

class Device;

/// A VkPipeline and who destroys it. Its users let go of it before their device goes, and not while commands run that
/// use it.
using SharedPipeline = std::shared_ptr<VkPipeline_T>;

/// Of one device. A pipeline may be bound with any layout that is defined as the one it was compiled with
/// [Vulkan 1.3, Pipeline Layout Compatibility], so that it outlives this.
class KeptPipelines {
public:
    /// So many are kept, those used last: some jobs' worth. What is in use lives on beyond that.
    static constexpr size_t kMost = 128;

    explicit KeptPipelines(const Device& device) : device_(device) {}

    /// What `compile` made when this key was last asked for, else what it makes now. `key` holds all that the pipeline
    /// is compiled from.
    SharedPipeline get(const std::string& key, const std::function<VkPipeline()>& compile);
    void clear() {
        by_key_.clear();
        kept_.clear();
    }

private:
    struct Kept {
        std::string key;
        SharedPipeline pipeline;
    };

    const Device& device_;
    std::list<Kept> kept_;  // the one used last first
    std::unordered_map<std::string, std::list<Kept>::iterator> by_key_;
};

}  // namespace photond::gpu
