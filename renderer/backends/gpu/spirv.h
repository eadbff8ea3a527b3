#pragma once
// Shaders as the build compiled them, by the path of their source, and what can be read off them.

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace photond::gpu {

/// One shader's words.
struct Shader {
    std::string_view source;  // "renderer/backends/gpu/radix_sort_scatter.comp"
    std::span<const uint32_t> words;
};

/// The shaders that are part of the program. Programs with shaders of their own (tests) add them at start.
void add_shaders(std::span<const Shader> shaders);
/// Throws ErrorCode::Internal when there is none of that source.
const Shader& find_shader(std::string_view source);

/// A storage buffer of descriptor set 0, as the shader declares it.
///
/// Its name is that of its block's only member, which is what the shader's code calls it: that of
/// `readonly buffer Keys { uint keys[]; }` is "keys". No block has an instance name, so GLSL itself sees to it that no
/// two members of a shader have one name. The block's own name says nothing.
struct ShaderBuffer {
    std::string_view name;  // views the shader's words; empty where the block has several members or was stripped
    uint32_t binding;
    bool read_only;  // declared readonly
};
/// Those of set 0, by binding.
std::vector<ShaderBuffer> buffers_of(std::span<const uint32_t> words);
/// The ids of the specialisation constants that the shader declares, rising.
std::vector<uint32_t> constants_of(std::span<const uint32_t> words);
/// Whether the shader reads the scene, which is descriptor set 1.
bool uses_scene(std::span<const uint32_t> words);

}  // namespace photond::gpu
