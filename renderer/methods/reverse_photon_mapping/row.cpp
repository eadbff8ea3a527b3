// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/gathering/photon_gathering.h"
#include "renderer/methods/reverse_photon_mapping/reverse_photon_mapping.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const ReversePhotonMappingParams& params, const Needs& needs) {
    return left_out_by_photons(bounces_of_scatterings(params.max_scatterings()), params.glossy_threshold, needs);
}

}  // namespace

MethodInfo reverse_photon_mapping_row();

MethodInfo reverse_photon_mapping_row() {
    MethodInfo info = row_of_classes<ReversePhotonMapping, void>();
    info.left_out = left_out_of<ReversePhotonMappingParams, paths_left_out>;
    info.title = "Reverse photon mapping";
    info.line =
        "Final gathering where photons seek the ends of rays. Photon mapping's image, sooner where rays are many.";
    info.family = "photon mapping";
    info.sources = {{"Havran, Herzog and Seidel", 2005, "Fast Final Gathering via Reverse Photon Mapping"},
                    {"Jensen", 1996, "Global Illumination using Photon Maps"}};
    info.layers.add(Layer::PhotonCount);
    info.artefacts = {{kPhotonMapFile, "model/gltf-binary", "keep_photon_map", "photon map"}};
    info.estimate_artefact_bytes = photon_map_file_bytes_of<ReversePhotonMapping>;
    info.variants = {{"fixed", {{"influence_radius", "fixed"}}}, {"knn", {{"influence_radius", "knn"}}}};
    info.limits = limits_of_density_estimates();
    return info;
}

}  // namespace photond
