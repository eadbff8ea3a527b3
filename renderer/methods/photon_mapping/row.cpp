// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/gathering/photon_gathering.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/methods/photon_mapping/photon_mapping_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const PhotonMappingParams& params, const Needs& needs) {
    return left_out_by_photons(bounces_of_scatterings(params.max_scatterings()), params.glossy_threshold, needs);
}

}  // namespace

MethodInfo photon_mapping_row();

MethodInfo photon_mapping_row() {
    MethodInfo info = row_of_classes<PhotonMapping, PhotonMappingGpu>();
    info.left_out = left_out_of<PhotonMappingParams, paths_left_out>;
    info.title = "Photon mapping";
    info.line =
        "Stores light paths' hits and gathers them. Good at caustics and in rooms lit indirectly; slightly blurred.";
    info.family = "photon mapping";
    info.sources = {{"Jensen", 1996, "Global Illumination using Photon Maps"},
                    {"Jensen", 1995, "Importance Driven Path Tracing using the Photon Map"},
                    {"Jensen and Christensen", 1995, "Efficiently Rendering Shadows using the Photon Map"},
                    {"Christensen", 1999, "Faster Photon Map Global Illumination"}};
    info.layers.add(Layer::PhotonCount);
    info.artefacts = {{kPhotonMapFile, "model/gltf-binary", "keep_photon_map", "photon map"}};
    info.estimate_artefact_bytes = photon_map_file_bytes_of<PhotonMapping>;
    info.settings_before = {{"boundary", "none"}, {"precompute_irradiance", "false"}};
    info.variants = {{"final", {{"gather", "final"}}}, {"direct", {{"gather", "direct"}}}};
    info.limits = limits_of_density_estimates();
    info.limits.push_back(
        {{{"gather", "direct"}}, "sphere", "the density estimate takes a curved surface for a flat one"});
    return info;
}

}  // namespace photond
