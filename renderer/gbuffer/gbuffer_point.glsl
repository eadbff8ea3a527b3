// What a point of the G-buffer is.
#ifndef PHOTOND_GBUFFER_POINT_GLSL
#define PHOTOND_GBUFFER_POINT_GLSL

#include "renderer/backends/gpu/scene.glsl"
#include "renderer/gbuffer/gbuffer_shared.h"

/// Whether it waits for indirect light.
bool is_lit(GBufferPoint point) { return (point.kind & GBUFFER_SCATTERINGS) != 0u; }
/// Whether it is not Lambert.
bool is_general(GBufferPoint point) { return !ONLY_LAMBERT && (point.kind & GBUFFER_GENERAL) != 0u; }

#endif
