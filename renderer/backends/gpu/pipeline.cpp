#include "renderer/backends/gpu/pipeline.h"

#include <algorithm>

namespace photond::gpu {

namespace {

constexpr VkShaderStageFlags kStages = VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_ALL_GRAPHICS;
constexpr uint32_t kMostPushed = 32;  // that every device takes [Vulkan 1.3, maxPushDescriptors]

VkDescriptorSetLayout make_set_layout(Device& device, std::span<const uint32_t> bindings,
                                      VkDescriptorSetLayoutCreateFlags flags, const std::string& name) {
    std::vector<VkDescriptorSetLayoutBinding> all;
    for (const uint32_t binding : bindings)
        all.push_back({binding, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, kStages, nullptr});
    VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    info.flags = flags;
    info.bindingCount = static_cast<uint32_t>(all.size());
    info.pBindings = all.data();
    VkDescriptorSetLayout layout;
    check(device.vk().vkCreateDescriptorSetLayout(device.handle(), &info, nullptr, &layout),
          "describing the buffers of " + name);
    return layout;
}

/// The buffers of set 0 that the stages of one pipeline have together, by binding.
std::vector<ShaderBuffer> buffers_of_all(std::span<const Shader* const> shaders) {
    std::vector<ShaderBuffer> all;
    for (const Shader* shader : shaders) {
        const std::string source(shader->source);
        for (const ShaderBuffer& buffer : buffers_of(shader->words)) {
            if (buffer.name.empty())
                throw Error(ErrorCode::Internal, source + ", binding " + std::to_string(buffer.binding) +
                                                     ": the buffer has no name; its block has several members, or "
                                                     "its names were stripped");
            const auto same = std::find_if(all.begin(), all.end(), [&](const ShaderBuffer& other) {
                return other.binding == buffer.binding || other.name == buffer.name;
            });
            if (same == all.end())
                all.push_back(buffer);
            else if (same->binding == buffer.binding && same->name == buffer.name)
                same->read_only &= buffer.read_only;
            else
                throw Error(ErrorCode::Internal, source + ": the buffer " + std::string(buffer.name) + " at binding " +
                                                     std::to_string(buffer.binding) + " is " + std::string(same->name) +
                                                     " at binding " + std::to_string(same->binding) +
                                                     " elsewhere in the pipeline");
        }
    }
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.binding < b.binding; });
    return all;
}

}  // namespace

BufferSet::BufferSet(Device& device, const std::string& name, std::span<Buffer* const> buffers)
    : device_(device), count_(static_cast<uint32_t>(buffers.size())) {
    for (uint32_t i = 0; i < count_; ++i)
        if (!buffers[i] || !*buffers[i])
            throw Error(ErrorCode::Internal, name + ", binding " + std::to_string(i) + ": no buffer");
    try {
        make(name, buffers);
    } catch (...) {
        destroy();
        throw;
    }
}

void BufferSet::make(const std::string& name, std::span<Buffer* const> buffers) {
    std::vector<uint32_t> bindings(count_);
    for (uint32_t i = 0; i < count_; ++i) bindings[i] = i;
    layout_ = make_set_layout(device_, bindings, 0, name);
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, count_};
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = 1;
    pool.poolSizeCount = 1;
    pool.pPoolSizes = &size;
    check(device_.vk().vkCreateDescriptorPool(device_.handle(), &pool, nullptr, &pool_), "binding " + name);
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool_;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &layout_;
    check(device_.vk().vkAllocateDescriptorSets(device_.handle(), &allocate, &set_), "binding " + name);
    std::vector<VkDescriptorBufferInfo> infos;
    for (const Buffer* buffer : buffers) infos.push_back({buffer->handle(), 0, VK_WHOLE_SIZE});
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = set_;
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    std::vector<VkWriteDescriptorSet> writes;
    for (uint32_t i = 0; i < count_; ++i) {
        write.dstBinding = i;
        write.descriptorCount = 1;
        write.pBufferInfo = &infos[i];
        writes.push_back(write);
    }
    device_.vk().vkUpdateDescriptorSets(device_.handle(), count_, writes.data(), 0, nullptr);
    device_.set_name(VK_OBJECT_TYPE_DESCRIPTOR_SET, reinterpret_cast<uint64_t>(set_), name);
}

BufferSet::~BufferSet() { destroy(); }

void BufferSet::destroy() noexcept {
    device_.vk().vkDestroyDescriptorPool(device_.handle(), pool_, nullptr);
    device_.vk().vkDestroyDescriptorSetLayout(device_.handle(), layout_, nullptr);
}

PipelineLayout::PipelineLayout(Device& device, std::span<const Shader* const> shaders, uint32_t push_bytes,
                               const BufferSet* scene)
    : device_(device), buffers_(buffers_of_all(shaders)), push_bytes_(push_bytes), scene_(scene) {
    const std::string name(shaders.front()->source);
    const bool reads_scene =
        std::any_of(shaders.begin(), shaders.end(), [](const Shader* shader) { return uses_scene(shader->words); });
    if (reads_scene && !scene) throw Error(ErrorCode::Internal, name + " reads the scene, which was not given");
    if (push_bytes > device.limits().push_constants || push_bytes % 4 != 0)
        throw Error(ErrorCode::Internal, name + " has " + std::to_string(push_bytes) +
                                             " bytes of push constants; the device takes " +
                                             std::to_string(device.limits().push_constants));
    const size_t all = buffers_.size() + (scene ? scene->buffers() : 0);
    if (buffers_.size() > kMostPushed || all > device.limits().storage_buffers)
        throw Error(ErrorCode::Internal, name + " has " + std::to_string(buffers_.size()) + " buffers, " +
                                             std::to_string(all) + " with the scene's; the device takes " +
                                             std::to_string(kMostPushed) + " and " +
                                             std::to_string(device.limits().storage_buffers));
    std::vector<uint32_t> bindings;
    for (const ShaderBuffer& buffer : buffers_) bindings.push_back(buffer.binding);
    set_layout_ = make_set_layout(device, bindings, VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR, name);
    const VkDescriptorSetLayout sets[] = {set_layout_, scene ? scene->layout() : VK_NULL_HANDLE};
    const VkPushConstantRange range{kStages, 0, push_bytes};
    VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    info.setLayoutCount = scene ? 2 : 1;
    info.pSetLayouts = sets;
    info.pushConstantRangeCount = push_bytes > 0 ? 1 : 0;
    info.pPushConstantRanges = &range;
    const VkResult result = device.vk().vkCreatePipelineLayout(device.handle(), &info, nullptr, &handle_);
    if (result != VK_SUCCESS) device.vk().vkDestroyDescriptorSetLayout(device.handle(), set_layout_, nullptr);
    check(result, "laying out " + name);
}

PipelineLayout::~PipelineLayout() {
    device_.vk().vkDestroyPipelineLayout(device_.handle(), handle_, nullptr);
    device_.vk().vkDestroyDescriptorSetLayout(device_.handle(), set_layout_, nullptr);
}

std::string PipelineLayout::key() const {
    return " push " + std::to_string(push_bytes_) + " scene " + (scene_ ? std::to_string(scene_->buffers()) : "none");
}

std::string key_of(const Shader& shader, std::span<const Specialization> constants) {
    const std::vector<uint32_t> declared = constants_of(shader.words);
    std::string key = " " + std::string(shader.source);
    for (const Specialization& constant : constants)
        if (std::binary_search(declared.begin(), declared.end(), constant.id))
            key += " " + std::to_string(constant.id) + "=" + std::to_string(constant.value);
    return key;
}

ShaderStage::ShaderStage(Device& device, VkShaderStageFlagBits stage, const Shader& shader,
                         std::span<const Specialization> constants)
    : device_(device) {
    std::vector<uint32_t> words = specialized(shader, constants);
    if (device.limits().keeps_infinities) words = with_infinities(words);
    VkShaderModuleCreateInfo module{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    module.codeSize = words.size() * sizeof(uint32_t);
    module.pCode = words.data();
    info_.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info_.stage = stage;
    info_.pName = "main";
    check(device.vk().vkCreateShaderModule(device.handle(), &module, nullptr, &info_.module),
          "loading " + std::string(shader.source));
}

ShaderStage::~ShaderStage() { device_.vk().vkDestroyShaderModule(device_.handle(), info_.module, nullptr); }

ComputePipeline::ComputePipeline(Device& device, std::string_view source, uint32_t push_bytes, const BufferSet* scene,
                                 std::span<const Specialization> constants)
    : shader_(find_shader(source)),
      layout_(device, std::initializer_list<const Shader*>{&shader_}, push_bytes, scene),
      handle_(device.pipelines().get(layout_.key() + key_of(shader_, constants),
                                     [&] { return compile(device, constants); })) {}

VkPipeline ComputePipeline::compile(Device& device, std::span<const Specialization> constants) const {
    const ShaderStage stage(device, VK_SHADER_STAGE_COMPUTE_BIT, shader_, constants);
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage = stage.info();
    info.layout = layout_.handle();
    VkPipeline pipeline;
    check(device.vk().vkCreateComputePipelines(device.handle(), device.pipeline_cache(), 1, &info, nullptr, &pipeline),
          "compiling " + std::string(source()));
    device.set_name(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(pipeline), std::string(source()));
    return pipeline;
}

}  // namespace photond::gpu
