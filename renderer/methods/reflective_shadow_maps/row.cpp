// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/reflective_shadow_maps/reflective_shadow_maps_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const ReflectiveShadowMapsParams& params, const Needs& needs) {
    return left_out_by_connections(params.bounces, params.glossy_threshold, params.connect_threshold, needs);
}

}  // namespace

MethodInfo reflective_shadow_maps_row();

MethodInfo reflective_shadow_maps_row() {
    MethodInfo info = row_of_classes<void, ReflectiveShadowMapsGpu>();
    info.left_out = left_out_of<ReflectiveShadowMapsParams, paths_left_out>;
    info.title = "Reflective shadow maps";
    info.line = "One bounce without shadows of its own. The fastest and the least exact.";
    info.family = "many lights";
    info.sources = {{"Dachsbacher and Stamminger", 2005, "Reflective Shadow Maps"}};
    info.layers.remove(Layer::Caustic);
    info.limits = {{{}, "", "nobody asks what stands between, and what the clamp takes is not given back"}};
    return info;
}

}  // namespace photond
