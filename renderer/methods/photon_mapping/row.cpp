// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/methods/photon_mapping/photon_mapping_gpu.h"
#include "renderer/photons/photon_cloud.h"

namespace photond {

namespace {

/// The photons the file will hold are those that keeping the maps adds to the memory.
uint64_t photon_map_file_bytes(const MethodParams& params, const Workload& workload) {
    PhotonMappingParams kept = dynamic_cast<const PhotonMappingParams&>(params);
    if (!kept.keep_photon_map) return 0;
    PhotonMappingParams thrown_away = kept;
    thrown_away.keep_photon_map = false;
    const uint64_t map_bytes =
        PhotonMapping::estimate_bytes(kept, workload) - PhotonMapping::estimate_bytes(thrown_away, workload);
    constexpr uint64_t kPhotons = 1'000'000;
    const double photons =
        static_cast<double>(map_bytes) * kPhotons / static_cast<double>(PhotonMap::bytes_for(kPhotons));
    return photon_cloud_bytes(static_cast<uint64_t>(photons));
}

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
    info.artefacts = {{PhotonMapping::kArtefact, "model/gltf-binary", "keep_photon_map", "photon map"}};
    info.estimate_artefact_bytes = photon_map_file_bytes;
    info.settings_before = {{"boundary", "none"}};
    info.variants = {{"final", {{"gather", "final"}}}, {"direct", {{"gather", "direct"}}}};
    info.limits = {{{{"boundary", "none"}},
                    "thin wall",
                    "a disc of the density estimate does not see a wall thinner than its radius"},
                   {{},
                    "thin wall",
                    "places of a disc are looked up at random: a sliver of it behind a wall is missed now and then"},
                   {{{"boundary", "none"}}, "corner", "lookups of the density estimate reach past the edge"},
                   {{}, "corner", "the density estimate smears light within its radius"},
                   {{}, "facing", "the density estimate loses light within its radius of edges"},
                   {{}, "caustic", "the density estimate smears light within its radius"},
                   {{{"gather", "direct"}}, "sphere", "the density estimate takes a curved surface for a flat one"}};
    return info;
}

}  // namespace photond
