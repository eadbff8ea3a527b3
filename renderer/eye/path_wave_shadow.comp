#version 460
// The wavefront's shadow rays: the light samples that nothing stands before.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

#include "renderer/eye/path_wave.glsl"

void main() {
    const uint i = flat_index();
    if (i >= wave_queues[WAVE_NOW(WAVE_SHADOWS)]) return;
    const ShadowState shadow = path_shadows[i];
    count(COUNTER_SHADOW_RAYS, 1);
    if (occluded(Ray(shadow.origin, shadow.direction, shadow.t_max))) return;
    add_rgb(shadow.indirect != 0 ? LAYER_INDIRECT : LAYER_DIRECT, shadow.pixel, shadow.radiance);
}
