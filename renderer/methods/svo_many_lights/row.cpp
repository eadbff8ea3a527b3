// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/methods/svo_many_lights/svo_many_lights_gpu.h"

namespace photond {

MethodInfo svo_many_lights_row();

MethodInfo svo_many_lights_row() {
    MethodInfo info = row_of_classes<SvoManyLights, SvoManyLightsGpu>();
    info.title = "Many lights, sparse voxel octree";
    info.line =
        "Bounced light as many small lights, caustics by photons. Very fast on diffuse scenes; by voxels it darkens.";
    info.family = "many lights";
    info.sources = {{"Sun", 2015, "Many-Light Real-Time Global Illumination using Sparse Voxel Octree"},
                    {"Keller", 1997, "Instant Radiosity"},
                    {"Kollig and Keller", 2004, "Illumination in the Presence of Weak Singularities"},
                    {"Clarberg et al.", 2005, "Wavelet Importance Sampling"}};
    for (const Layer layer : {Layer::Clamped, Layer::Voxels, Layer::Vpls, Layer::SplitNormal, Layer::SplitIndirect})
        info.layers.add(layer);
    info.layers.remove(Layer::Caustic);
    info.variants = {{"rays", {{"visibility", "rays"}}}, {"voxels", {{"visibility", "svo"}}}};
    info.limits = {
        kStartsByPower,
        {{}, "furnace", "as many bounces as it was given here, where the answer has all of them"},
        {{}, "caustic", "photons smear light within the radius of a lookup, which shrinks from pass to pass"},
        {{{"visibility", "svo"}},
         "thin wall",
         "where both ends lie within a voxel or two of a wall thinner than one, the voxels they are freed of "
         "are the wall"}};
    return info;
}

}  // namespace photond
