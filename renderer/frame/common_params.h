#pragma once
// Parameters and checks that methods of several families have in common, declared once.

#include <cstdint>

namespace photond {

class ParamVisitor;
enum class SamplerKind : uint8_t;

/// `sampler`: where the numbers of the passes come from.
void visit_sampler(ParamVisitor& visitor, SamplerKind& sampler);
/// Throws ErrorCode::OutOfRange at `pointer` ("/map_resolution") unless `value` is 0 or a power of two.
void require_power_of_two(const char* pointer, uint32_t value);

}  // namespace photond
