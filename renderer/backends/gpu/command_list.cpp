#include "renderer/backends/gpu/command_list.h"

#include <algorithm>
#include <map>

#include "renderer/backends/gpu/image.h"
#include "renderer/backends/gpu/instance.h"

namespace photond::gpu {

namespace {

constexpr uint32_t kMostScopes = 512;
constexpr uint64_t kMostThreads = 1ull << 31;  // and those of rows that are not full: flat_index() has 32 bits
constexpr uint64_t kMostUpdated = 65536;       // bytes [Vulkan 1.3, vkCmdUpdateBuffer]
constexpr VkAccessFlags2 kWrites = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT |
                                   VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
                                   VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
// For whatever device stage comes to read it later: one barrier serves them all.
constexpr VkPipelineStageFlags2 kLaterStages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
constexpr VkAccessFlags2 kLaterAccess = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
constexpr VkShaderStageFlags kPushStages = VK_SHADER_STAGE_COMPUTE_BIT | VK_SHADER_STAGE_ALL_GRAPHICS;

Error misfit(std::string_view source, std::string_view buffer, const std::string& what) {
    return Error(ErrorCode::Internal, std::string(source) + ", buffer " + std::string(buffer) + ": " + what);
}

}  // namespace

VkAccessFlags2 flags_of(Access access) {
    return (access != Access::Write ? VK_ACCESS_2_SHADER_STORAGE_READ_BIT : 0) |
           (access != Access::Read ? VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT : 0);
}

CommandList::CommandList(Device& device) : device_(device) {
    try {
        make();
        begin();
    } catch (...) {
        destroy();
        throw;
    }
}

void CommandList::make() {
    const VolkDeviceTable& vk = device_.vk();
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.queueFamilyIndex = device_.queue_family();
    check(vk.vkCreateCommandPool(device_.handle(), &pool, nullptr, &pool_), "making a command pool");
    VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocate.commandPool = pool_;
    allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocate.commandBufferCount = 1;
    check(vk.vkAllocateCommandBuffers(device_.handle(), &allocate, &commands_), "making a command buffer");
    VkQueryPoolCreateInfo queries{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    queries.queryType = VK_QUERY_TYPE_TIMESTAMP;
    queries.queryCount = 2 * kMostScopes;
    check(vk.vkCreateQueryPool(device_.handle(), &queries, nullptr, &queries_), "making timestamps");
}

CommandList::~CommandList() {
    if (submitted_) {
        try {
            device_.wait(*submitted_);
        } catch (const Error&) {
            submitted_.reset();  // a lost device has dropped the work; there is nothing to wait for
        }
    } else if (used_) {
        device_.drop_barriers();
    }
    destroy();
}

void CommandList::destroy() noexcept {
    device_.vk().vkDestroyQueryPool(device_.handle(), queries_, nullptr);
    device_.vk().vkDestroyCommandPool(device_.handle(), pool_, nullptr);
}

void CommandList::begin() {
    VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(device_.vk().vkBeginCommandBuffer(commands_, &info), "recording commands");
    device_.vk().vkResetQueryPool(device_.handle(), queries_, 0, 2 * kMostScopes);
    barrier_ = {VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    image_barriers_.clear();
    coming_uses_.clear();
    needs_barrier_ = rendering_ = used_ = false;
    layout_ = nullptr;
    scopes_.clear();
    bound_.clear();
}

void CommandList::reset() {
    wait();
    if (used_ && !submitted_) device_.drop_barriers();
    submitted_.reset();
    check(device_.vk().vkResetCommandPool(device_.handle(), pool_, 0), "recording commands anew");
    begin();
}

void CommandList::bind(const ComputePipeline& pipeline, std::span<const Binding> bindings) {
    device_.vk().vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.handle());
    bind_buffers(VK_PIPELINE_BIND_POINT_COMPUTE, pipeline.layout(), pipeline.source(), bindings);
}

void CommandList::bind_buffers(VkPipelineBindPoint point, const PipelineLayout& layout, std::string_view source,
                               std::span<const Binding> bindings) {
    const std::span<const ShaderBuffer> buffers = layout.buffers();
    std::vector<VkDescriptorBufferInfo> infos(buffers.size());
    std::vector<VkWriteDescriptorSet> writes(buffers.size(), {VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET});
    for (const Binding& binding : bindings) {
        const auto found = std::find_if(buffers.begin(), buffers.end(),
                                        [&](const ShaderBuffer& buffer) { return buffer.name == binding.name; });
        if (found == buffers.end()) throw misfit(source, binding.name, "the shader has no such buffer");
        const auto place = static_cast<size_t>(found - buffers.begin());
        if (writes[place].descriptorCount > 0) throw misfit(source, binding.name, "bound twice");
        if (!binding.buffer || !*binding.buffer) throw misfit(source, binding.name, "no buffer");
        if ((binding.access == Access::Read) != found->read_only)
            throw misfit(source, binding.name, "the shader declares another access to " + binding.buffer->structure());
        infos[place] = {binding.buffer->handle(), binding.offset, binding.bytes};
        writes[place].dstBinding = found->binding;
        writes[place].descriptorCount = 1;
        writes[place].descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        writes[place].pBufferInfo = &infos[place];
    }
    for (size_t i = 0; i < buffers.size(); ++i)
        if (writes[i].descriptorCount == 0) throw misfit(source, buffers[i].name, "not bound");
    layout_ = &layout;
    bound_.assign(bindings.begin(), bindings.end());
    if (!writes.empty())
        device_.vk().vkCmdPushDescriptorSetKHR(commands_, point, layout.handle(), 0,
                                               static_cast<uint32_t>(writes.size()), writes.data());
    if (layout.scene()) {
        const VkDescriptorSet set = layout.scene()->handle();
        device_.vk().vkCmdBindDescriptorSets(commands_, point, layout.handle(), 1, 1, &set, 0, nullptr);
    }
}

void CommandList::push_bytes(std::span<const std::byte> bytes) {
    if (!layout_ || bytes.size() != layout_->push_bytes())
        throw Error(ErrorCode::Internal, "push constants of " + std::to_string(bytes.size()) + " bytes do not fit");
    device_.vk().vkCmdPushConstants(commands_, layout_->handle(), kPushStages, 0, static_cast<uint32_t>(bytes.size()),
                                    bytes.data());
}

void CommandList::use(Buffer& buffer, VkPipelineStageFlags2 stage, VkAccessFlags2 access) {
    begin_use(buffer.structure());
    coming_uses_.push_back({&buffer.state(), stage, access});
}

/// A write waits for all before it; a read for the last write, unless another read did already. What the command that
/// comes does to one buffer in several ways is judged by what was before it, and noted together.
void CommandList::take_uses() {
    std::vector<UseState*> waited_for;
    for (const Use& use : coming_uses_) {
        const UseState& state = *use.state;
        const bool writes = (use.access & kWrites) != 0;
        if (!state.write_stages && !(writes && state.read_stages)) continue;
        barrier_.srcStageMask |= state.write_stages | (writes ? state.read_stages : 0);
        barrier_.srcAccessMask |= state.write_access;
        barrier_.dstStageMask |= kLaterStages;
        barrier_.dstAccessMask |= kLaterAccess;
        needs_barrier_ = true;
        waited_for.push_back(use.state);
    }
    for (UseState* state : waited_for) *state = {};
    for (const Use& use : coming_uses_) note(*use.state, use.stage, use.access);
    coming_uses_.clear();
}

void CommandList::begin_use(const std::string& structure) {
    if (rendering_) throw Error(ErrorCode::Internal, structure + " cannot be waited for within a raster pass");
    if (submitted_) throw Error(ErrorCode::Internal, structure + " is used by commands that are submitted already");
    used_ = true;
}

void CommandList::note(UseState& state, VkPipelineStageFlags2 stage, VkAccessFlags2 access) {
    if (access & kWrites) {
        state.write_stages |= stage;
        state.write_access |= access & kWrites;
    } else {
        state.read_stages |= stage;
    }
}

void CommandList::use(Image& image, VkPipelineStageFlags2 stage, VkAccessFlags2 access, VkImageLayout layout,
                      bool discard) {
    begin_use(image.structure());
    ImageState& state = image.state();
    // Changing the layout writes the image.
    const bool writes = (access & kWrites) != 0 || state.layout != layout;
    if (state.use.write_stages || (writes && state.use.read_stages) || state.layout != layout) {
        VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
        barrier.srcStageMask = state.use.write_stages | (writes ? state.use.read_stages : 0);
        barrier.srcAccessMask = state.use.write_access;
        barrier.dstStageMask = kLaterStages;
        barrier.dstAccessMask = kLaterAccess;
        barrier.oldLayout = discard ? VK_IMAGE_LAYOUT_UNDEFINED : state.layout;
        barrier.newLayout = layout;
        barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
        barrier.image = image.handle();
        barrier.subresourceRange = {image.aspect(), 0, 1, 0, image.layers()};
        image_barriers_.push_back(barrier);
        needs_barrier_ = true;
        state = {{}, layout};
    }
    note(state.use, stage, access);
}

void CommandList::flush_barrier() {
    take_uses();
    if (!needs_barrier_) return;
    VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    info.memoryBarrierCount = barrier_.dstStageMask ? 1 : 0;
    info.pMemoryBarriers = &barrier_;
    info.imageMemoryBarrierCount = static_cast<uint32_t>(image_barriers_.size());
    info.pImageMemoryBarriers = image_barriers_.data();
    device_.vk().vkCmdPipelineBarrier2(commands_, &info);
    barrier_ = {VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    image_barriers_.clear();
    needs_barrier_ = false;
}

void CommandList::begin_rendering(const VkRenderingInfo& info) {
    if (rendering_) throw Error(ErrorCode::Internal, "raster passes do not nest");
    flush_barrier();
    device_.vk().vkCmdBeginRendering(commands_, &info);
    rendering_ = true;
}

void CommandList::end_rendering() {
    device_.vk().vkCmdEndRendering(commands_);
    rendering_ = false;
    layout_ = nullptr;
    bound_.clear();
}

void CommandList::use_bound() {
    if (!layout_) throw Error(ErrorCode::Internal, "a dispatch before anything was bound");
    for (const Binding& binding : bound_)
        use(*binding.buffer, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, flags_of(binding.access));
}

void CommandList::dispatch(uint32_t x, uint32_t y, uint32_t z) {
    const uint32_t* most = device_.limits().workgroups;
    if (x > most[0] || y > most[1] || z > most[2])
        throw Error(ErrorCode::Internal, "a dispatch of " + std::to_string(x) + " x " + std::to_string(y) + " x " +
                                             std::to_string(z) + " groups passes the device's limit");
    use_bound();
    flush_barrier();
    device_.vk().vkCmdDispatch(commands_, x, y, z);
}

void CommandList::dispatch_threads(uint64_t threads, uint32_t group_size) {
    if (threads == 0) return;
    if (threads > kMostThreads)
        throw Error(ErrorCode::Internal, "a dispatch of " + std::to_string(threads) + " threads cannot number them");
    const uint64_t count = (threads + group_size - 1) / group_size;
    const uint64_t most = std::min<uint64_t>(device_.limits().workgroups[0], 1u << 15);
    const uint64_t rows = (count + most - 1) / most;
    dispatch(static_cast<uint32_t>(rows > 1 ? most : count), static_cast<uint32_t>(rows));
}

void CommandList::dispatch_indirect(Buffer& counts, uint64_t offset) {
    use_bound();
    use(counts, VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT);
    flush_barrier();
    device_.vk().vkCmdDispatchIndirect(commands_, counts.handle(), offset);
}

void CommandList::fill(Buffer& buffer, uint32_t word) { fill(buffer, word, 0, buffer.bytes() / 4 * 4); }

void CommandList::fill(Buffer& buffer, uint32_t word, uint64_t offset, uint64_t bytes) {
    use(buffer, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    flush_barrier();
    device_.vk().vkCmdFillBuffer(commands_, buffer.handle(), offset, bytes, word);
}

void CommandList::update(Buffer& buffer, std::span<const std::byte> bytes, uint64_t offset) {
    if (bytes.empty() || bytes.size() > kMostUpdated || bytes.size() % 4 != 0)
        throw Error(ErrorCode::Internal,
                    buffer.structure() + " cannot be updated by " + std::to_string(bytes.size()) + " bytes at once");
    use(buffer, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    flush_barrier();
    device_.vk().vkCmdUpdateBuffer(commands_, buffer.handle(), offset, bytes.size(), bytes.data());
}

void CommandList::copy(Buffer& from, uint64_t from_offset, Buffer& to, uint64_t to_offset, uint64_t bytes) {
    use(from, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
    use(to, VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    flush_barrier();
    const VkBufferCopy region{from_offset, to_offset, bytes};
    device_.vk().vkCmdCopyBuffer(commands_, from.handle(), to.handle(), 1, &region);
}

void CommandList::host_reads(Buffer&) {
    barrier_.srcStageMask |= VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier_.srcAccessMask |= VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier_.dstStageMask |= VK_PIPELINE_STAGE_2_HOST_BIT;
    barrier_.dstAccessMask |= VK_ACCESS_2_HOST_READ_BIT;
    needs_barrier_ = true;
}

void CommandList::begin_scope(const std::string& name) {
    if (scopes_.size() == kMostScopes)
        throw Error(ErrorCode::Internal, "a list of more than " + std::to_string(kMostScopes) + " scopes");
    if (Instance::get()->debug_names()) {
        VkDebugUtilsLabelEXT label{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
        label.pLabelName = name.c_str();
        vkCmdBeginDebugUtilsLabelEXT(commands_, &label);
    }
    device_.vk().vkCmdWriteTimestamp2(commands_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_,
                                      static_cast<uint32_t>(2 * scopes_.size()));
    scopes_.push_back(name);
}

void CommandList::end_scope() {
    device_.vk().vkCmdWriteTimestamp2(commands_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_,
                                      static_cast<uint32_t>(2 * scopes_.size()) - 1);
    if (Instance::get()->debug_names()) vkCmdEndDebugUtilsLabelEXT(commands_);
}

void CommandList::submit() {
    if (submitted_ || rendering_)
        throw Error(ErrorCode::Internal, rendering_ ? "a raster pass is not ended" : "commands are submitted already");
    flush_barrier();
    check(device_.vk().vkEndCommandBuffer(commands_), "recording commands");
    times_.clear();
    submitted_ = device_.submit(commands_);
}

bool CommandList::done() { return !submitted_ || device_.reached(*submitted_); }

void CommandList::wait() {
    if (!submitted_) return;
    device_.wait(*submitted_);
    if (!times_.empty() || scopes_.empty()) return;
    const auto count = static_cast<uint32_t>(scopes_.size());
    std::vector<uint64_t> ticks(2 * count);
    check(device_.vk().vkGetQueryPoolResults(device_.handle(), queries_, 0, 2 * count, ticks.size() * sizeof(uint64_t),
                                             ticks.data(), sizeof(uint64_t),
                                             VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
          "reading timestamps");
    for (uint32_t i = 0; i < count; ++i)
        times_.push_back(
            {scopes_[i], static_cast<double>(ticks[2 * i + 1] - ticks[2 * i]) * device_.limits().timestamp_seconds});
}

void CommandList::add_times(Stats& stats) const {
    for (const ScopeTime& time : times_) stats.stage(time.name).gpu_seconds += time.seconds;
}

}  // namespace photond::gpu
