// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/image_based_lighting/image_based_lighting.h"
#include "renderer/methods/image_based_lighting/image_based_lighting_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const ImageBasedLightingParams& params, const Needs& needs) {
    return PathsLeftOut(params.bounces, needs);
}

}  // namespace

MethodInfo image_based_lighting_row();

MethodInfo image_based_lighting_row() {
    MethodInfo info = row_of_classes<ImageBasedLighting, ImageBasedLightingGpu>();
    info.left_out = left_out_of<ImageBasedLightingParams, paths_left_out>;
    info.title = "Image-based lighting";
    info.line = "The environment blurred for each roughness, without shadows or bounces. For real time, in the open.";
    info.family = "image-based lighting";
    info.sources = {{"Karis", 2013, "Real Shading in Unreal Engine 4"},
                    {"Walter et al.", 2007, "Microfacet Models for Refraction through Rough Surfaces"}};
    info.layers.remove(Layer::Caustic);
    info.limits = {{{}, "", "nobody asks what stands before the environment, and no light bounces"}};
    return info;
}

}  // namespace photond
