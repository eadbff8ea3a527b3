#pragma once
// Parameters and checks that methods of several families have in common, declared once.

#include <cstdint>

namespace photond {

class ParamVisitor;
enum class SamplerKind : uint8_t;

/// `sampler`: where the numbers of the passes come from.
void visit_sampler(ParamVisitor& visitor, SamplerKind& sampler);

/// What of the last frame's indirect light a frame of an animation takes over.
enum class TemporalReuse : uint8_t { None, Reproject };

/// Members of a method's parameters, as `temporal`, where its indirect light can be taken over from frame to frame
/// (gbuffer/temporal_reprojection.h).
struct TemporalParams {
    TemporalReuse reuse = TemporalReuse::None;
    uint32_t history_cap = 16;  // frames that a pixel's light is the mean of, at most

    void visit(ParamVisitor& visitor);
};

/// Throws ErrorCode::OutOfRange at `pointer` ("/map_resolution") unless `value` is 0 or a power of two.
void require_power_of_two(const char* pointer, uint32_t value);

}  // namespace photond
