#pragma once
// What shaders counted (counters.glsl), and its way to the host.

#include "renderer/backends/gpu/command_list.h"
#include "renderer/backends/gpu/counters_shared.h"

namespace photond::gpu {

class Counters {
public:
    static constexpr uint64_t kBytes = 2 * COUNTERS * sizeof(uint32_t);  // on the device, and of the host's copy

    Counters() = default;  // holds nothing
    explicit Counters(Device& device)
        : counters_(device, "counters", kBytes), host_(device, "readback", kBytes, MemoryKind::Readback) {}

    gpu::Buffer& buffer() { return counters_; }
    void record_clear(CommandList& commands) { commands.fill(counters_, 0); }
    void record_readback(CommandList& commands);
    /// Adds them, once that has been waited for.
    void read(Counts& counts) const;

private:
    Buffer counters_, host_;
};

}  // namespace photond::gpu
