#pragma once
// Raster passes: triangles whose vertices the vertex shader pulls from storage buffers, drawn into images.

#include <array>

#include "renderer/backends/gpu/image.h"

namespace photond::gpu {

enum class Blend : uint8_t {
    None,
    Add,  // to what is there, every channel; in the order of the triangles, so the same bits every time
};

struct RasterTarget {
    VkFormat format;
    Blend blend = Blend::None;
};

/// What a pipeline draws, and into what.
struct RasterOptions {
    std::vector<RasterTarget> colors;  // by the fragment shader's output location
    bool depth = false;                // tested against a D32_SFLOAT image: kept is what is strictly nearer
    bool depth_write = true;
    VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
};

/// Compiled vertex and fragment shaders. Front and back faces are drawn; clip space is Vulkan's: y down, z in 0..w.
class RasterPipeline {
public:
    /// `vertex`, `fragment`: as in find_shader(); their buffers of set 0 are numbered and named together, so that what
    /// both have is at one binding under one name. `push_bytes`, `scene`, `constants`: as in ComputePipeline, for both
    /// shaders. Throws ErrorCode::Unsupported, naming the format, where the device cannot blend or draw what the
    /// options say; ErrorCode::Internal where shaders and arguments do not fit, and for a vertex shader with a buffer
    /// that it does not declare readonly.
    RasterPipeline(Device& device, std::string_view vertex, std::string_view fragment, uint32_t push_bytes,
                   const RasterOptions& options, const BufferSet* scene = nullptr,
                   std::span<const Specialization> constants = {});
    RasterPipeline(const RasterPipeline&) = delete;
    RasterPipeline& operator=(const RasterPipeline&) = delete;

    VkPipeline handle() const { return handle_.get(); }
    const PipelineLayout& layout() const { return layout_; }
    const RasterOptions& options() const { return options_; }
    std::string_view source() const { return fragment_.source; }

private:
    void check_formats() const;
    std::string key(std::span<const Specialization> constants) const;
    VkPipeline compile(std::span<const Specialization> constants) const;

    Device& device_;
    const Shader &vertex_, &fragment_;
    const RasterOptions options_;
    const PipelineLayout layout_;
    const SharedPipeline handle_;
};

/// One layer of an image as a pass draws into it: what is there stays, or becomes one value.
struct Attachment {
    Image* image;
    std::optional<VkClearValue> clear;
    uint32_t layer = 0;
};
inline Attachment load(Image& image, uint32_t layer = 0) { return {&image, std::nullopt, layer}; }
/// Colours of float images.
inline Attachment clear(Image& image, std::array<float, 4> color, uint32_t layer = 0) {
    return {&image, VkClearValue{.color = {.float32 = {color[0], color[1], color[2], color[3]}}}, layer};
}
/// Colours of uint images.
inline Attachment clear(Image& image, std::array<uint32_t, 4> color, uint32_t layer = 0) {
    return {&image, VkClearValue{.color = {.uint32 = {color[0], color[1], color[2], color[3]}}}, layer};
}
inline Attachment clear_depth(Image& image, float depth = 1, uint32_t layer = 0) {
    return {&image, VkClearValue{.depthStencil = {depth, 0}}, layer};
}

/// A part of the targets, in pixels from the upper left.
struct PixelRect {
    uint32_t x, y, width, height;
};

/// Where a pass draws. All images are of one size.
struct RasterTargets {
    std::vector<Attachment> colors;  // those of RasterOptions, in their order
    std::optional<Attachment> depth;
};

/// Draws into a command list from its making to end(); in between only its own functions, push() and scopes may be
/// recorded there. Barriers follow from the bindings, which stand for all draws of the pass.
class RasterPass {
public:
    /// `bindings`: as in CommandList::bind(). `indirect`: the buffer draw_indirect() reads, if there is one. Viewport
    /// and scissor are the whole target. Throws ErrorCode::Internal where targets or bindings do not fit the pipeline,
    /// and for load() of an image that nothing was written to.
    RasterPass(CommandList& commands, const RasterPipeline& pipeline, const RasterTargets& targets,
               std::span<const Binding> bindings, Buffer* indirect = nullptr);
    RasterPass(CommandList& commands, const RasterPipeline& pipeline, const RasterTargets& targets,
               std::initializer_list<Binding> bindings, Buffer* indirect = nullptr)
        : RasterPass(commands, pipeline, targets, std::span(bindings.begin(), bindings.size()), indirect) {}
    ~RasterPass() { end(); }
    RasterPass(const RasterPass&) = delete;
    RasterPass& operator=(const RasterPass&) = delete;

    /// Clip space maps to this part for the next draws, and nothing outside of it is drawn.
    void viewport(const PixelRect& part);
    template <class T>
    void push(const T& constants) {
        commands_.push(constants);
    }
    void draw(uint32_t vertices, uint32_t instances = 1);
    /// VkDrawIndirectCommand at `offset`, a multiple of 4, of the pass's indirect buffer; its first instance must be 0.
    void draw_indirect(uint64_t offset = 0);
    /// The last of the pass; a second time it does nothing.
    void end();

private:
    CommandList& commands_;
    Buffer* indirect_;
    PixelRect all_{};
    bool ended_ = false;
};

}  // namespace photond::gpu
