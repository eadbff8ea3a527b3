#pragma once
// Compiled compute shaders, with constants fixed for what a scene needs.

#include <vector>

#include "renderer/backends/gpu/buffer.h"
#include "renderer/backends/gpu/shader_specialization.h"
#include "renderer/backends/gpu/spirv.h"

namespace photond::gpu {

/// Buffers that many shaders read and none writes, bound together as descriptor set 1: the scene.
class BufferSet {
public:
    /// Borrows the buffers, which must stay. Binding i is buffers[i]; throws ErrorCode::Internal where that holds
    /// nothing.
    BufferSet(Device& device, const std::string& name, std::span<Buffer* const> buffers);
    ~BufferSet();
    BufferSet(const BufferSet&) = delete;
    BufferSet& operator=(const BufferSet&) = delete;

    VkDescriptorSetLayout layout() const { return layout_; }
    VkDescriptorSet handle() const { return set_; }
    uint32_t buffers() const { return count_; }

private:
    void make(const std::string& name, std::span<Buffer* const> buffers);
    void destroy() noexcept;

    Device& device_;
    const uint32_t count_;
    VkDescriptorSetLayout layout_ = VK_NULL_HANDLE;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
};

/// What a shader's interface is: its buffers of set 0, and whether it reads the scene.
class PipelineLayout {
public:
    /// Throws ErrorCode::Internal where shaders and arguments do not fit, and where the shaders do not give each buffer
    /// one name of its own.
    PipelineLayout(Device& device, std::span<const Shader* const> shaders, uint32_t push_bytes, const BufferSet* scene);
    ~PipelineLayout();
    PipelineLayout(const PipelineLayout&) = delete;
    PipelineLayout& operator=(const PipelineLayout&) = delete;

    VkPipelineLayout handle() const { return handle_; }
    /// What it is made of beside the shaders, as text: layouts of the same shaders with the same text are compatible.
    std::string key() const;
    std::span<const ShaderBuffer> buffers() const { return buffers_; }
    uint32_t push_bytes() const { return push_bytes_; }
    const BufferSet* scene() const { return scene_; }

private:
    Device& device_;
    std::vector<ShaderBuffer> buffers_;
    uint32_t push_bytes_;
    const BufferSet* scene_;
    VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
    VkPipelineLayout handle_ = VK_NULL_HANDLE;
};

class ComputePipeline {
public:
    /// `source` as in find_shader(). `push_bytes`: size of the shader's push constants, a multiple of 4. `scene`: where
    /// the shader reads one; borrowed. Throws ErrorCode::Internal where shader and arguments do not fit.
    ComputePipeline(Device& device, std::string_view source, uint32_t push_bytes, const BufferSet* scene = nullptr,
                    std::span<const Specialization> constants = {});
    ComputePipeline(Device& device, std::string_view source, uint32_t push_bytes, const BufferSet* scene,
                    std::initializer_list<Specialization> constants)
        : ComputePipeline(device, source, push_bytes, scene, std::span(constants.begin(), constants.size())) {}
    ComputePipeline(const ComputePipeline&) = delete;
    ComputePipeline& operator=(const ComputePipeline&) = delete;

    VkPipeline handle() const { return handle_.get(); }
    const PipelineLayout& layout() const { return layout_; }
    std::string_view source() const { return shader_.source; }

private:
    VkPipeline compile(Device& device, std::span<const Specialization> constants) const;

    const Shader& shader_;
    const PipelineLayout layout_;
    SharedPipeline handle_;
};

/// The constants that the shader declares as text, for the key of a pipeline: others make no difference to it.
std::string key_of(const Shader& shader, std::span<const Specialization> constants);

/// A shader stage with its constants, for those who make pipelines. Owns the module; lives while they are made.
class ShaderStage {
public:
    ShaderStage(Device& device, VkShaderStageFlagBits stage, const Shader& shader,
                std::span<const Specialization> constants);
    ~ShaderStage();
    ShaderStage(const ShaderStage&) = delete;
    ShaderStage& operator=(const ShaderStage&) = delete;
    const VkPipelineShaderStageCreateInfo& info() const { return info_; }

private:
    Device& device_;
    VkPipelineShaderStageCreateInfo info_{};
};

}  // namespace photond::gpu
