#include "renderer/many_lights/vpl_tree_gpu.h"

#include <array>
#include <bit>

namespace photond {

static_assert(1u << VPL_TREE_GROUP_LEVELS == VPL_TREE_GROUP);

VplTreeGpu::VplTreeGpu(gpu::Device& device, uint32_t most)
    : most_(most),
      nodes_(device, "vpl_tree", 2 * uint64_t{std::bit_ceil(most)} * sizeof(gpu::VplTreeNode)),
      state_(device, "vpl_tree", VPL_TREE_STATE_WORDS * sizeof(uint32_t)),
      keys_(device, "vpl_tree", uint64_t{most} * sizeof(uint32_t)),
      lights_(device, "vpl_tree", uint64_t{most} * sizeof(uint32_t)),
      sort_(device, most),
      box_(device, "renderer/many_lights/vpl_tree_box.comp", sizeof(gpu::VplTreePush)),
      find_keys_(device, "renderer/many_lights/vpl_tree_keys.comp", sizeof(gpu::VplTreePush)),
      make_nodes_(device, "renderer/many_lights/vpl_tree_nodes.comp", sizeof(gpu::VplTreePush)) {}

uint64_t VplTreeGpu::device_bytes(uint32_t most) {
    constexpr uint64_t kWordsOfSort = 4;  // keys and lights, and those of the sort
    return 2 * uint64_t{std::bit_ceil(most)} * sizeof(gpu::VplTreeNode) + kWordsOfSort * most * sizeof(uint32_t);
}

void VplTreeGpu::record(gpu::CommandList& commands, gpu::Buffer& vpls, gpu::DeviceWord count) {
    const gpu::Scope scope(commands, "vpl_generation");
    const uint32_t nothing = ~0u;
    commands.update(state_, std::array<uint32_t, VPL_TREE_STATE_WORDS>{nothing, nothing, nothing, 0, 0, 0});
    gpu::VplTreePush push{.most = most_, .count_word = count.index, .level = 0};
    commands.bind(box_,
                  {gpu::read("counts", *count.buffer), gpu::read("vpls", vpls), gpu::read_write("state", state_)});
    commands.push(push);
    commands.dispatch_threads(most_, VPL_TREE_GROUP);
    commands.bind(find_keys_, {gpu::read("counts", *count.buffer), gpu::read("vpls", vpls), gpu::read("state", state_),
                               gpu::write("keys", keys_), gpu::write("lights", lights_)});
    commands.push(push);
    commands.dispatch_threads(most_, VPL_TREE_GROUP);
    sort_.record(commands, keys_, lights_, count, VPL_KEY_BITS);
    for (uint32_t left = std::bit_ceil(most_);; left >>= VPL_TREE_GROUP_LEVELS) {
        commands.bind(make_nodes_, {gpu::read("counts", *count.buffer), gpu::read("vpls", vpls),
                                    gpu::read("lights", lights_), gpu::read_write("nodes", nodes_)});
        commands.push(push);
        commands.dispatch_threads(left, VPL_TREE_GROUP);
        push.level += VPL_TREE_GROUP_LEVELS;
        if (left <= VPL_TREE_GROUP) break;
    }
}

}  // namespace photond
