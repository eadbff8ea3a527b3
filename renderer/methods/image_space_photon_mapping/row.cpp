// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/image_space_photon_mapping/image_space_photon_mapping_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const ImageSpacePhotonMappingParams& params, const Needs& needs) {
    return left_out_by_photons(params.bounces.value_or(PathsLeftOut::kAllBounces), params.glossy_threshold, needs);
}

constexpr const char* kMiddles =
    "a light whose middle is seen counts as seen whole: lights behind windows are too bright";

}  // namespace

MethodInfo image_space_photon_mapping_row();

MethodInfo image_space_photon_mapping_row() {
    MethodInfo info = row_of_classes<void, ImageSpacePhotonMappingGpu>();
    info.left_out = left_out_of<ImageSpacePhotonMappingParams, paths_left_out>;
    info.title = "Image-space photon mapping";
    info.line = "Photons light the pixels about them. For real time, caustics included; blurred by their size.";
    info.family = "photon mapping";
    info.sources = {
        {"McGuire and Luebke", 2009, "Hardware-Accelerated Global Illumination by Image Space Photon Mapping"},
        {"Yao", 2011, "Combining Soft Shadow and Image Space Photon Mapping for Global Illumination"}};
    info.layers.remove(Layer::Caustic);
    for (const Layer layer :
         {Layer::Overlap, Layer::ShadowDistance, Layer::BlurRadius, Layer::UpsamplingWeight, Layer::BounceMap})
        info.layers.add(layer);
    info.bias_falls_with = {{{"shrink", "true"}, {"subsampling", "1"}, {"soft_shadow", "rays"}}};
    info.limits = {{{{"boundary", "none"}}, "", "whole footprints lose light where a surface ends within them"},
                   {{{"footprint", "volume"}}, "", "volumes light what lies behind thin walls"},
                   {{{"soft_shadow", "gather"}}, "", kMiddles},
                   {{{"soft_shadow", "fixed_radius"}}, "", kMiddles},
                   {{{"soft_shadow", "none"}}, "", kMiddles}};
    return info;
}

}  // namespace photond
