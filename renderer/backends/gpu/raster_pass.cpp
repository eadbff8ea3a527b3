#include "renderer/backends/gpu/raster_pass.h"

#include <algorithm>

namespace photond::gpu {

namespace {

constexpr VkPipelineStageFlags2 kShaderStages =
    VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;

Error misfit(const RasterPipeline& pipeline, const std::string& what) {
    return Error(ErrorCode::Internal, std::string(pipeline.source()) + ": " + what);
}

}  // namespace

RasterPipeline::RasterPipeline(Device& device, std::string_view vertex, std::string_view fragment, uint32_t push_bytes,
                               const RasterOptions& options, const BufferSet* scene,
                               std::span<const Specialization> constants)
    : device_(device),
      vertex_(find_shader(vertex)),
      fragment_(find_shader(fragment)),
      options_(options),
      layout_(device, std::initializer_list<const Shader*>{&vertex_, &fragment_}, push_bytes, scene),
      handle_(device.pipelines().get(key(constants), [&] { return compile(constants); })) {}

std::string RasterPipeline::key(std::span<const Specialization> constants) const {
    std::string key = layout_.key() + key_of(vertex_, constants) + key_of(fragment_, constants) + " topology " +
                      std::to_string(options_.topology) + " depth " + std::to_string(options_.depth) +
                      std::to_string(options_.depth_write);
    for (const RasterTarget& target : options_.colors)
        key += " " + std::to_string(target.format) + "/" + std::to_string(static_cast<int>(target.blend));
    return key;
}

void RasterPipeline::check_formats() const {
    const auto need = [&](VkFormat format, VkFormatFeatureFlags feature, const char* doing) {
        if (format_features(device_, format) & feature) return;
        throw Error(ErrorCode::Unsupported, device_.report().name + " cannot " + doing + " images of " +
                                                format_name(format) + ", which " + std::string(source()) + " needs");
    };
    for (const RasterTarget& target : options_.colors) {
        need(target.format, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT, "draw into");
        if (target.blend == Blend::Add) need(target.format, VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BLEND_BIT, "blend into");
    }
    if (options_.depth) need(VK_FORMAT_D32_SFLOAT, VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT, "draw into");
    for (const ShaderBuffer& buffer : buffers_of(vertex_.words))
        if (!buffer.read_only)
            throw Error(ErrorCode::Internal, std::string(vertex_.source) + ", buffer " + std::string(buffer.name) +
                                                 ": vertex shaders only read");
}

VkPipeline RasterPipeline::compile(std::span<const Specialization> constants) const {
    check_formats();
    const ShaderStage vertex(device_, VK_SHADER_STAGE_VERTEX_BIT, vertex_, constants);
    const ShaderStage fragment(device_, VK_SHADER_STAGE_FRAGMENT_BIT, fragment_, constants);
    const VkPipelineShaderStageCreateInfo stages[] = {vertex.info(), fragment.info()};
    const VkPipelineVertexInputStateCreateInfo no_vertices{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    assembly.topology = options_.topology;
    VkPipelineViewportStateCreateInfo viewports{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    viewports.viewportCount = viewports.scissorCount = 1;
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.cullMode = VK_CULL_MODE_NONE;
    raster.lineWidth = 1;
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    depth.depthTestEnable = options_.depth;
    depth.depthWriteEnable = options_.depth && options_.depth_write;
    depth.depthCompareOp = VK_COMPARE_OP_LESS;
    std::vector<VkFormat> formats;
    std::vector<VkPipelineColorBlendAttachmentState> blends;
    for (const RasterTarget& target : options_.colors) {
        formats.push_back(target.format);
        VkPipelineColorBlendAttachmentState blend{};
        blend.blendEnable = target.blend == Blend::Add;
        blend.srcColorBlendFactor = blend.dstColorBlendFactor = VK_BLEND_FACTOR_ONE;
        blend.srcAlphaBlendFactor = blend.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
        blend.colorBlendOp = blend.alphaBlendOp = VK_BLEND_OP_ADD;
        blend.colorWriteMask =
            VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
        blends.push_back(blend);
    }
    VkPipelineColorBlendStateCreateInfo blending{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    blending.attachmentCount = static_cast<uint32_t>(blends.size());
    blending.pAttachments = blends.data();
    const VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    dynamic.dynamicStateCount = static_cast<uint32_t>(std::size(dynamic_states));
    dynamic.pDynamicStates = dynamic_states;
    VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
    rendering.colorAttachmentCount = static_cast<uint32_t>(formats.size());
    rendering.pColorAttachmentFormats = formats.data();
    rendering.depthAttachmentFormat = options_.depth ? VK_FORMAT_D32_SFLOAT : VK_FORMAT_UNDEFINED;

    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO, &rendering};
    info.stageCount = static_cast<uint32_t>(std::size(stages));
    info.pStages = stages;
    info.pVertexInputState = &no_vertices;
    info.pInputAssemblyState = &assembly;
    info.pViewportState = &viewports;
    info.pRasterizationState = &raster;
    info.pMultisampleState = &samples;
    info.pDepthStencilState = &depth;
    info.pColorBlendState = &blending;
    info.pDynamicState = &dynamic;
    info.layout = layout_.handle();
    VkPipeline pipeline;
    check(device_.vk().vkCreateGraphicsPipelines(device_.handle(), device_.pipeline_cache(), 1, &info, nullptr,
                                                 &pipeline),
          "compiling " + std::string(source()));
    device_.set_name(VK_OBJECT_TYPE_PIPELINE, reinterpret_cast<uint64_t>(pipeline), std::string(source()));
    return pipeline;
}

namespace {

struct Use {
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 access;
    VkImageLayout layout;
};
constexpr Use kColorUse{VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                        VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                        VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
constexpr Use kDepthUse{VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
                        VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
                        VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL};

VkRenderingAttachmentInfo describe(const Attachment& attachment, const Use& use) {
    VkRenderingAttachmentInfo info{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    info.imageView = attachment.image->view(attachment.layer);
    info.imageLayout = use.layout;
    info.loadOp = attachment.clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
    info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    if (attachment.clear) info.clearValue = *attachment.clear;
    return info;
}

/// Every target, where all fit the pipeline and each other; else throws.
std::vector<const Attachment*> checked(const RasterPipeline& pipeline, const RasterTargets& targets) {
    const RasterOptions& options = pipeline.options();
    if (targets.colors.size() != options.colors.size() || targets.depth.has_value() != options.depth)
        throw misfit(pipeline, "other targets than the pipeline's");
    std::vector<const Attachment*> all;
    for (size_t i = 0; i < targets.colors.size(); ++i) {
        if (targets.colors[i].image->format() != options.colors[i].format)
            throw misfit(pipeline, targets.colors[i].image->structure() + " is not of the pipeline's format");
        all.push_back(&targets.colors[i]);
    }
    if (targets.depth) {
        if (targets.depth->image->format() != VK_FORMAT_D32_SFLOAT)
            throw misfit(pipeline, targets.depth->image->structure() + " is not of depths");
        all.push_back(&*targets.depth);
    }
    if (all.empty()) throw misfit(pipeline, "a pass without targets");
    for (const Attachment* attachment : all) {
        Image &image = *attachment->image, &first = *all.front()->image;
        if (image.width() != first.width() || image.height() != first.height())
            throw misfit(pipeline, image.structure() + " and " + first.structure() + " are of different sizes");
        if (attachment->layer >= image.layers())
            throw misfit(pipeline, image.structure() + " has no layer " + std::to_string(attachment->layer));
        if (!attachment->clear && image.state().layout == VK_IMAGE_LAYOUT_UNDEFINED)
            throw misfit(pipeline, image.structure() + " holds nothing to be kept");
    }
    return all;
}

}  // namespace

RasterPass::RasterPass(CommandList& commands, const RasterPipeline& pipeline, const RasterTargets& targets,
                       std::span<const Binding> bindings, Buffer* indirect)
    : commands_(commands), indirect_(indirect) {
    const std::vector<const Attachment*> all = checked(pipeline, targets);
    commands.bind_buffers(VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.layout(), pipeline.source(), bindings);
    for (const Binding& binding : bindings) commands.use(*binding.buffer, kShaderStages, flags_of(binding.access));
    if (indirect) commands.use(*indirect, VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT);

    std::vector<VkRenderingAttachmentInfo> colors;
    VkRenderingAttachmentInfo depth;
    for (const Attachment* attachment : all) {
        Image& image = *attachment->image;
        const bool is_depth = image.aspect() == VK_IMAGE_ASPECT_DEPTH_BIT;
        const Use& use = is_depth ? kDepthUse : kColorUse;
        commands.use(image, use.stages, use.access, use.layout, attachment->clear && image.layers() == 1);
        if (is_depth)
            depth = describe(*attachment, use);
        else
            colors.push_back(describe(*attachment, use));
    }
    all_ = {0, 0, all.front()->image->width(), all.front()->image->height()};
    VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
    info.renderArea.extent = {all_.width, all_.height};
    info.layerCount = 1;
    info.colorAttachmentCount = static_cast<uint32_t>(colors.size());
    info.pColorAttachments = colors.data();
    info.pDepthAttachment = targets.depth ? &depth : nullptr;
    commands.begin_rendering(info);
    commands.device().vk().vkCmdBindPipeline(commands.handle(), VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.handle());
    viewport(all_);
}

void RasterPass::viewport(const PixelRect& part) {
    if (part.x > all_.width || part.width > all_.width - part.x || part.y > all_.height ||
        part.height > all_.height - part.y || part.width == 0 || part.height == 0)
        throw Error(ErrorCode::Internal, "a viewport is not within its targets");
    const VkViewport viewport{static_cast<float>(part.x),
                              static_cast<float>(part.y),
                              static_cast<float>(part.width),
                              static_cast<float>(part.height),
                              0,
                              1};
    const VkRect2D scissor{{static_cast<int32_t>(part.x), static_cast<int32_t>(part.y)}, {part.width, part.height}};
    const VolkDeviceTable& vk = commands_.device().vk();
    vk.vkCmdSetViewport(commands_.handle(), 0, 1, &viewport);
    vk.vkCmdSetScissor(commands_.handle(), 0, 1, &scissor);
}

void RasterPass::draw(uint32_t vertices, uint32_t instances) {
    commands_.device().vk().vkCmdDraw(commands_.handle(), vertices, instances, 0, 0);
}

void RasterPass::draw_indirect(uint64_t offset) {
    if (!indirect_) throw Error(ErrorCode::Internal, "a pass without a buffer for its indirect draws");
    commands_.device().vk().vkCmdDrawIndirect(commands_.handle(), indirect_->handle(), offset, 1,
                                              sizeof(VkDrawIndirectCommand));
}

void RasterPass::end() {
    if (ended_) return;
    commands_.end_rendering();
    ended_ = true;
}

}  // namespace photond::gpu
