#pragma once
// VplTree (vpl_tree.h) on a device, of as many lights as only the device knows.

#include "renderer/backends/gpu/radix_sort.h"
#include "renderer/many_lights/vpl_tree_shared.h"

namespace photond {

/// Borrows its device. One record at a time may be under way.
class VplTreeGpu {
public:
    /// `most`: lights, at least 1; those past it are left out.
    VplTreeGpu(gpu::Device& device, uint32_t most);
    static uint64_t device_bytes(uint32_t most);

    /// vpls: Vpl. Nodes are numbered as VplTree's of that many lights; scope `vpl_generation`.
    void record(gpu::CommandList& commands, gpu::Buffer& vpls, gpu::DeviceWord count);
    gpu::Buffer& nodes() { return nodes_; }  // VplTreeNode

private:
    const uint32_t most_;
    gpu::Buffer nodes_, state_, keys_, lights_;
    gpu::RadixSort sort_;
    gpu::ComputePipeline box_, find_keys_, make_nodes_;
};

}  // namespace photond
