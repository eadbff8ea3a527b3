#pragma once
// Shaders with their constants put in before a driver sees them.

#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/backends/gpu/spirv.h"

namespace photond::gpu {

/// Values for `layout(constant_id = i)`: 4 bytes each.
struct Specialization {
    uint32_t id;
    uint32_t value;
};
inline Specialization specialize(uint32_t id, bool value) { return {id, value ? 1u : 0u}; }
inline Specialization specialize(uint32_t id, uint32_t value) { return {id, value}; }
inline Specialization specialize(uint32_t id, float value) { return {id, std::bit_cast<uint32_t>(value)}; }

/// The shader's words with the constants at these values, those it does not declare passed over, and without what
/// cannot be reached then; its buffers stay. A driver copies every function into each of its callers before it looks at
/// constants: of a path tracer's instructions a third is left this way where all is diffuse. Throws ErrorCode::Internal
/// where the words are no SPIR-V.
std::vector<uint32_t> specialized(const Shader& shader, std::span<const Specialization> constants);

/// The shader's words, held to what IEEE 754 says of infinities, NaN and the sign of 0 in 32 bits. Unless a shader asks
/// for that, a driver may take it that there are none [SPIR-V 1.6, SignedZeroInfNanPreserve]; for devices with
/// Limits::keeps_infinities. Throws ErrorCode::Internal where the words are no SPIR-V.
std::vector<uint32_t> with_infinities(std::span<const uint32_t> words);

}  // namespace photond::gpu
