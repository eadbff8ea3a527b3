// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/imperfect_shadow_maps/imperfect_shadow_maps_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const ImperfectShadowMapsParams& params, const Needs& needs) {
    return left_out_by_connections(params.bounces, params.glossy_threshold, params.connect_threshold, needs);
}

}  // namespace

MethodInfo imperfect_shadow_maps_row();

MethodInfo imperfect_shadow_maps_row() {
    MethodInfo info = row_of_classes<void, ImperfectShadowMapsGpu>();
    info.left_out = left_out_of<ImperfectShadowMapsParams, paths_left_out>;
    info.title = "Imperfect shadow maps";
    info.line = "Many small lights with coarse shadow maps. For real time, one bounce, approximate shadows.";
    info.family = "many lights";
    info.sources = {
        {"Ritschel et al.", 2008, "Imperfect Shadow Maps for Efficient Computation of Indirect Illumination"},
        {"Marroquim et al.", 2007, "Efficient Point-Based Rendering Using Image Reconstruction"},
        {"Segovia et al.", 2007, "Metropolis Instant Radiosity"},
        {"Georgiev and Slusallek", 2010, "Simple and Robust Iterative Importance Sampling of Virtual Point Lights"},
        {"Laine et al.", 2007, "Incremental Instant Radiosity for Real-Time Indirect Illumination"}};
    info.layers.remove(Layer::Caustic);
    info.limits = {
        {{}, "", "maps of a few texels, by points instead of triangles, and what the clamp takes is not given back"}};
    return info;
}

}  // namespace photond
