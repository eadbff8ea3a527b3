#pragma once
// Work for the device: recorded, submitted, waited for. What each command reads and writes is declared where it is
// bound; the barriers between commands follow from that, from list to list.

#include <optional>
#include <string>
#include <vector>

#include "renderer/backends/gpu/pipeline.h"
#include "renderer/core/stats.h"

namespace photond::gpu {

class Image;

enum class Access : uint8_t { Read, Write, ReadWrite };
/// What a shader does to a storage buffer.
VkAccessFlags2 flags_of(Access access);

/// A buffer as a command uses it, by the name that the shader has for it (ShaderBuffer::name). The order of a list of
/// them says nothing.
struct Binding {
    std::string_view name;  // viewed until something else is bound: a literal, or one of PipelineLayout::buffers()
    Buffer* buffer;
    Access access;
    uint64_t offset = 0;  // bytes; a multiple of 256
    uint64_t bytes = VK_WHOLE_SIZE;
};
inline Binding read(std::string_view name, Buffer& buffer) { return {name, &buffer, Access::Read}; }
inline Binding write(std::string_view name, Buffer& buffer) { return {name, &buffer, Access::Write}; }
inline Binding read_write(std::string_view name, Buffer& buffer) { return {name, &buffer, Access::ReadWrite}; }

/// GPU seconds of one scope.
struct ScopeTime {
    std::string name;
    double seconds;
};

/// Lists are submitted in the order they are recorded in. Borrows what it is told of until it has been waited for;
/// going away, it waits. Not thread-safe.
class CommandList {
public:
    explicit CommandList(Device& device);
    ~CommandList();
    CommandList(const CommandList&) = delete;
    CommandList& operator=(const CommandList&) = delete;

    /// What dispatch() runs next. Throws ErrorCode::Internal where the bindings are not those of the shader: a name
    /// that it has not, one given twice or not at all, and read() for a buffer that it does not declare readonly
    /// (write() and read_write() for one it does).
    void bind(const ComputePipeline& pipeline, std::span<const Binding> bindings);
    void bind(const ComputePipeline& pipeline, std::initializer_list<Binding> bindings) {
        bind(pipeline, std::span(bindings.begin(), bindings.size()));
    }
    template <class T>
    void push(const T& constants) {
        push_bytes(std::as_bytes(std::span(&constants, 1)));
    }

    void dispatch(uint32_t x, uint32_t y = 1, uint32_t z = 1);
    /// At least `threads` threads in groups of `group_size`; shaders number them by flat_index() (invocation.glsl), and
    /// those past the end have nothing to do. 0: nothing is run. Throws ErrorCode::Internal past 2^31.
    void dispatch_threads(uint64_t threads, uint32_t group_size);
    /// Three counts of groups, read at `offset` of the buffer.
    void dispatch_indirect(Buffer& counts, uint64_t offset);

    void fill(Buffer& buffer, uint32_t word);  // all of it
    void fill(Buffer& buffer, uint32_t word, uint64_t offset, uint64_t bytes);
    /// Copies up to 64 KiB at recording, a multiple of 4 bytes; ErrorCode::Internal for others.
    void update(Buffer& buffer, std::span<const std::byte> bytes, uint64_t offset = 0);
    template <class T>
    void update(Buffer& buffer, const T& value) {
        update(buffer, std::as_bytes(std::span(&value, 1)));
    }
    void copy(Buffer& from, uint64_t from_offset, Buffer& to, uint64_t to_offset, uint64_t bytes);
    /// What was written there will be read by the host.
    void host_reads(Buffer& buffer);

    /// Between the two the device's time counts for that name; scopes do not nest. Throws ErrorCode::Internal past 512
    /// in a list.
    void begin_scope(const std::string& name);
    void end_scope();

    /// Starts it after all that was submitted before. Once, until reset(); nothing is recorded after.
    void submit();
    /// Until it is done; at once where it was never submitted. Throws DeviceLost.
    void wait();
    bool done();
    /// Of the last submission, once waited for, in the order of recording; several of one name stay several.
    const std::vector<ScopeTime>& times() const { return times_; }
    /// Adds them to the stages of those names.
    void add_times(Stats& stats) const;
    /// Waits, and begins anew.
    void reset();

    /// For raster passes (raster_pass.h), which record into the same list.
    VkCommandBuffer handle() const { return commands_; }
    Device& device() { return device_; }
    /// Declares a use outside of dispatch(), and makes it wait for those before.
    void use(Buffer& buffer, VkPipelineStageFlags2 stage, VkAccessFlags2 access);
    /// The same of an image, which will be in that layout. `discard`: what it holds is not needed any more.
    void use(Image& image, VkPipelineStageFlags2 stage, VkAccessFlags2 access, VkImageLayout layout,
             bool discard = false);
    /// Binds buffers to any pipeline of that layout, as bind() does. `source`: the shader, for what errors say.
    void bind_buffers(VkPipelineBindPoint point, const PipelineLayout& layout, std::string_view source,
                      std::span<const Binding> bindings);
    void flush_barrier();
    /// Between the two only what needs no barrier may be recorded: uses throw ErrorCode::Internal.
    void begin_rendering(const VkRenderingInfo& info);
    /// Nothing is bound after.
    void end_rendering();

private:
    void make();
    void destroy() noexcept;
    void begin();
    void begin_use(const std::string& structure);
    void push_bytes(std::span<const std::byte> bytes);
    void use_bound();
    static void note(UseState& state, VkPipelineStageFlags2 stage, VkAccessFlags2 access);
    void take_uses();

    Device& device_;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;
    VkQueryPool queries_ = VK_NULL_HANDLE;
    std::vector<std::string> scopes_;
    std::vector<ScopeTime> times_;
    std::optional<uint64_t> submitted_;
    const PipelineLayout* layout_ = nullptr;
    std::vector<Binding> bound_;
    /// Of the command that comes, until its barrier is recorded.
    struct Use {
        UseState* state;
        VkPipelineStageFlags2 stage;
        VkAccessFlags2 access;
    };
    std::vector<Use> coming_uses_;
    VkMemoryBarrier2 barrier_{};
    std::vector<VkImageMemoryBarrier2> image_barriers_;
    bool needs_barrier_ = false;
    bool rendering_ = false;
    bool used_ = false;  // something, since it began
};

/// A scope as long as it lives.
class Scope {
public:
    Scope(CommandList& commands, const std::string& name) : commands_(commands) { commands.begin_scope(name); }
    ~Scope() { commands_.end_scope(); }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

private:
    CommandList& commands_;
};

constexpr uint32_t groups(uint64_t threads, uint32_t group_size) {
    return static_cast<uint32_t>((threads + group_size - 1) / group_size);
}

}  // namespace photond::gpu
