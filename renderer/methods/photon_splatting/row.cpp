// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/methods/photon_splatting/photon_splatting_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const PhotonSplattingParams& params, const Needs& needs) {
    uint32_t bounces = bounces_of_scatterings(params.max_scatterings());
    if (params.injection == PhotonInjection::ReflectiveShadowMap) bounces = std::min(bounces, 1u);
    return left_out_by_photons(bounces, params.glossy_threshold, needs);
}

}  // namespace

MethodInfo photon_splatting_row();

MethodInfo photon_splatting_row() {
    MethodInfo info = row_of_classes<PhotonSplatting, PhotonSplattingGpu>();
    info.left_out = left_out_of<PhotonSplattingParams, paths_left_out>;
    info.title = "Photon splatting";
    info.line = "Light paths connect to all that is visible near them. First pictures soon, with little memory.";
    info.family = "photon splatting";
    info.sources = {{"Hoet", 2014, "Indirect Illumination using Photon Splatting"},
                    {"Dachsbacher and Stamminger", 2006, "Splatting Indirect Illumination"},
                    {"Kollig and Keller", 2004, "Illumination in the Presence of Weak Singularities"}};
    info.layers.add(Layer::Overlap);
    info.layers.remove(Layer::Caustic);
    info.bias_falls_with = {{{"shrink", "true"}, {"weighting", "radiometric"}}};
    info.settings_before = {{"bounces", "1"}};
    info.variants = {{"connect", {{"weighting", "radiometric"}, {"estimator", "connect"}}},
                     {"kernel", {{"weighting", "radiometric"}, {"estimator", "kernel"}}},
                     {"normalised", {{"weighting", "normalised"}}}};
    info.limits = {
        {{{"weighting", "normalised"}},
         "",
         "a weighted mean of the photons' colours: it discards how dense they are, so no exposure makes it "
         "converge"},
        {{{"estimator", "kernel"}},
         "thin wall",
         "a depth map lights borderline depths, to a texel's width, which is more than the wall's"},
        {{}, "furnace", "as many bounces as it was given here, where the answer has all of them"},
        {{{"estimator", "kernel"}}, "glass", "beams from specular surfaces are as wide as a splat"},
        {{{"estimator", "kernel"}}, "corner", "the kernel darkens within a radius of edges, by half there"},
        {{{"estimator", "kernel"}}, "two colours", "the kernel darkens within a radius of edges, by half there"},
        {{{"estimator", "kernel"}}, "facing", "the kernel darkens within a radius of edges, by half there"}};
    return info;
}

}  // namespace photond
