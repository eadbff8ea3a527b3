// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/methods/svo_many_lights/svo_many_lights_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const SvoManyLightsParams& params, const Needs& needs) {
    const uint32_t bounces = bounces_of_scatterings(params.max_scatterings());
    if (!params.narrow_lobes)
        return left_out_by_connections(bounces, params.glossy_threshold, params.connect_threshold, needs);
    PathsLeftOut left_out = left_out_by_photons(bounces, params.glossy_threshold, needs);
    if (params.caustic_photons == 0 && has_delta_light_by_delta(needs)) left_out.add(PathKind::DeltaLightCaustics);
    return left_out;
}

}  // namespace

MethodInfo svo_many_lights_row();

MethodInfo svo_many_lights_row() {
    MethodInfo info = row_of_classes<SvoManyLights, SvoManyLightsGpu>();
    info.left_out = left_out_of<SvoManyLightsParams, paths_left_out>;
    info.title = "Many lights, sparse voxel octree";
    info.line =
        "Bounced light as many small lights, caustics by photons. Very fast on diffuse scenes; by voxels it darkens.";
    info.family = "many lights";
    info.sources = {
        {"Sun", 2015, "Many-Light Real-Time Global Illumination using Sparse Voxel Octree"},
        {"Keller", 1997, "Instant Radiosity"},
        {"Kollig and Keller", 2004, "Illumination in the Presence of Weak Singularities"},
        {"Clarberg et al.", 2005, "Wavelet Importance Sampling"},
        {"Laine et al.", 2007, "Incremental Instant Radiosity for Real-Time Indirect Illumination"},
        {"Segovia et al.", 2007, "Metropolis Instant Radiosity"},
        {"Georgiev and Slusallek", 2010, "Simple and Robust Iterative Importance Sampling of Virtual Point Lights"},
        {"Thiedemann et al.", 2011, "Voxel-based Global Illumination"}};
    for (const Layer layer : {Layer::Clamped, Layer::Voxels, Layer::Vpls, Layer::SplitNormal, Layer::SplitIndirect})
        info.layers.add(layer);
    info.layers.remove(Layer::Caustic);
    info.settings_before = {{"bounces", "1"}, {"caustic_photons", "0"}};
    info.variants = {{"rays", {{"visibility", "rays"}}}, {"voxels", {{"visibility", "svo"}}}};
    info.limits = {
        {{}, "furnace", "as many bounces as it was given here, where the answer has all of them"},
        {{}, "caustic", "photons smear light within the radius of a lookup, which shrinks from pass to pass"},
        {{{"visibility", "svo"}},
         "thin wall",
         "where both ends lie within a voxel or two of a wall thinner than one, the voxels they are freed of "
         "are the wall"},
        {{{"visibility", "near_field"}},
         "",
         "what lies farther from a point than near_field_radius stands in no light"}};
    return info;
}

}  // namespace photond
