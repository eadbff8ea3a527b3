#pragma once
// Dispatches as large as a count that only the device knows.

#include "renderer/backends/gpu/command_list.h"

namespace photond::gpu {

/// One uint on the device: a word of a buffer.
struct DeviceWord {
    DeviceWord(Buffer& in, uint32_t at = 0) : buffer(&in), index(at) {}  // NOLINT: a buffer is its first word
    Buffer* buffer;
    uint32_t index;
};

/// Cuts a count of elements into tiles, one for each group of an indirect dispatch. Shaders that run by it include
/// device_tiles.glsl, bind state() and leave at once where tile_index() is not below tiles_state.tiles.
class DeviceTiles {
public:
    /// `structure`: the name of its 20 bytes in the accounts. `capacity`: most elements there can be, up to 2^31;
    /// `tile`: elements a group takes.
    DeviceTiles(Device& device, const std::string& structure, uint32_t capacity, uint32_t tile);

    /// Reads the count as it is then; a count past the capacity is taken for the capacity.
    void record(CommandList& commands, DeviceWord count);
    /// Runs what is bound, a group a tile; nothing for a count of 0.
    void dispatch(CommandList& commands) { commands.dispatch_indirect(state_, 0); }
    Buffer& state() { return state_; }
    uint32_t capacity() const { return capacity_; }
    uint32_t tile() const { return tile_; }
    uint32_t most_tiles() const { return (capacity_ + tile_ - 1) / tile_; }

private:
    const uint32_t capacity_, tile_, row_groups_;
    ComputePipeline pipeline_;
    Buffer state_;
};

}  // namespace photond::gpu
