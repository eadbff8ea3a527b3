#version 460
// How many lights lie in each pixel, a thread a light: CPU twin show_vpls(). The layer's floats are added to as words:
// sums of ones do not depend on their order.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/backends/gpu/invocation.glsl"
#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/gbuffer/split_buffer.glsl"
#include "renderer/frame/device_image_shared.h"
#include "renderer/eye/eye_shared.h"
#include "renderer/many_lights/vpl_set_shared.h"
#include "renderer/methods/svo_many_lights/svo_layers_shared.h"
#include "renderer/scene/camera_projection.glsl"

layout(constant_id = PLANE_VPLS_ID) const uint PLANE_VPLS = NO_PLANE;
layout(constant_id = PLANES_ID) const uint PLANES = 1;

layout(local_size_x = VPL_SET_GROUP) in;
layout(push_constant, scalar) uniform Push { SplitRecord split; };
layout(set = 0, binding = 0, scalar) buffer Layers { uint layer_words[]; };
layout(set = 0, binding = 1, scalar) readonly buffer Eye { EyeConstants eye; };
layout(set = 0, binding = 2, scalar) readonly buffer Points { GBufferPoint points[]; };
layout(set = 0, binding = 3, scalar) readonly buffer Counts { uint counts[VPL_COUNT_WORDS]; };
layout(set = 0, binding = 4, scalar) readonly buffer Vpls { Vpl vpls[]; };

void main() {
    const uint light = flat_index();
    if (light >= counts[VPL_COUNT]) return;
    const vec3 position = vpls[light].position;
    vec2 film;
    if (!project(eye.camera, position, film) || !(film.x >= 0.0 && film.y >= 0.0)) return;
    if (!(film.x < float(eye.width) && film.y < float(eye.height))) return;
    const uint x = uint(film.x), y = uint(film.y), point = split_point_of(split, x, y);
    const float depth_m = dot(position - eye.camera.position, eye.camera.forward);
    if (points[point].kind == 0u || !(abs(depth_m - points[point].depth_m) <= VPL_SHOWN_DEPTH * points[point].depth_m)) return;
    const uint word = PLANE_VPLS * (uint(layer_words.length()) / PLANES) + y * eye.width + x;
    uint seen = layer_words[word], expected;
    do {
        expected = seen;
        seen = atomicCompSwap(layer_words[word], expected, floatBitsToUint(uintBitsToFloat(expected) + 1.0));
    } while (seen != expected);
}
