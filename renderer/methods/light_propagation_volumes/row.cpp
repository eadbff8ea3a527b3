// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/light_propagation_volumes/light_propagation_volumes_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const LightPropagationVolumesParams& params, const Needs& needs) {
    return left_out_by_connections(params.bounces, params.glossy_threshold, params.connect_threshold, needs);
}

}  // namespace

MethodInfo light_propagation_volumes_row();

MethodInfo light_propagation_volumes_row() {
    MethodInfo info = row_of_classes<void, LightPropagationVolumesGpu>();
    info.left_out = left_out_of<LightPropagationVolumesParams, paths_left_out>;
    info.title = "Light propagation volumes";
    info.line = "Light that spreads through a grid of cells. For real time, all bounces, smooth and coarse.";
    info.family = "voxels";
    info.sources = {
        {"Kaplanyan and Dachsbacher", 2010, "Cascaded Light Propagation Volumes for Real-Time Indirect Illumination"}};
    info.layers.add(Layer::Volume);
    info.layers.remove(Layer::Caustic);
    info.limits = {
        {{}, "", "light is known by cells and a third of all directions: it spreads about edges, and into gloss"}};
    return info;
}

}  // namespace photond
