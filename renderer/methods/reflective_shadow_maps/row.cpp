// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/reflective_shadow_maps/reflective_shadow_maps_gpu.h"

namespace photond {

MethodInfo reflective_shadow_maps_row();

MethodInfo reflective_shadow_maps_row() {
    MethodInfo info = row_of_classes<void, ReflectiveShadowMapsGpu>();
    info.title = "Reflective shadow maps";
    info.line = "One bounce without shadows of its own. The fastest and the least exact.";
    info.family = "many lights";
    info.sources = {{"Dachsbacher and Stamminger", 2005, "Reflective Shadow Maps"}};
    info.layers.remove(Layer::Caustic);
    info.limits = {kStartsByPower,
                   {{}, "", "nobody asks what stands between, and what the clamp takes is not given back"}};
    return info;
}

}  // namespace photond
