#pragma once
// Reflected photons as virtual point lights.

#include <vector>

#include "renderer/many_lights/vpl.h"
#include "renderer/photons/photon_tracer.h"
#include "renderer/transport/bsdf.h"
#include "renderer/transport/surface.h"

namespace photond {

/// A BSDF that light is reflected by, as connections ask for it.
struct RoughOrigin {
    ShadingPoint surface;
    Bsdf rough;
    vec3 wi_world{0};
};
/// Of a photon with Spread::Rough; its rough part above that GGX alpha.
RoughOrigin make_rough_origin(const Scene& scene, const ReflectingSurface& at, float threshold);

/// The lights of a pass. Those whose photons are beams are left out.
struct VplSet {
    std::vector<Vpl> vpls;
    std::vector<RoughOrigin> rough;  // Vpl::surface

    void assign(const Scene& scene, const TracedReflections& photons, float connect_threshold);
    uint64_t bytes() const { return vpls.capacity() * sizeof(Vpl) + rough.capacity() * sizeof(RoughOrigin); }
};

}  // namespace photond
