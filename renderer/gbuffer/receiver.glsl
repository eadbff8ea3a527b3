// Visible points that are not Lambert, made ready for shading again.
#ifndef PHOTOND_RECEIVER_GLSL
#define PHOTOND_RECEIVER_GLSL

#include "renderer/gbuffer/gbuffer_shared.h"
#include "renderer/transport/bsdf_material.glsl"

/// VisiblePoint, as far as it scatters.
struct Receiver {
    ShadingPoint surface;
    Bsdf rough;
    vec3 wo;  // local
};

Receiver make_receiver(GBufferGeneral general, float glossy_threshold) {
    Receiver receiver;
    const Hit hit = Hit(general.t, general.instance, general.triangle, general.u, general.v);
    receiver.surface = make_shading_point(hit, general.ray_direction);
    receiver.rough = bsdf_rough_part(make_bsdf(receiver.surface, general.outside_ior), glossy_threshold);
    receiver.wo = to_local(receiver.surface.shading, -general.ray_direction);
    return receiver;
}

#endif
