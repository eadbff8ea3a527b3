#include "renderer/methods/registry.h"

#include <algorithm>

#include "renderer/methods/imperfect_shadow_maps/imperfect_shadow_maps_gpu.h"
#include "renderer/methods/path_tracing/path_tracing.h"
#include "renderer/methods/path_tracing/path_tracing_gpu.h"
#include "renderer/methods/photon_mapping/photon_mapping.h"
#include "renderer/methods/photon_mapping/photon_mapping_gpu.h"
#include "renderer/methods/photon_splatting/photon_splatting.h"
#include "renderer/methods/photon_splatting/photon_splatting_gpu.h"
#include "renderer/methods/reflective_shadow_maps/reflective_shadow_maps_gpu.h"
#include "renderer/methods/svo_many_lights/svo_many_lights.h"
#include "renderer/methods/svo_many_lights/svo_many_lights_gpu.h"
#include "renderer/photons/photon_cloud.h"

namespace photond {

namespace {

/// What a row says of a method, whose class names its parameters `Params`, wherever it runs.
template <class M>
MethodInfo described(std::string_view title, std::string_view family, std::vector<std::string_view> sources,
                     std::vector<std::string_view> devices) {
    MethodInfo info;
    info.name = M::kName;
    info.title = title;
    info.family = family;
    info.sources = std::move(sources);
    info.devices = std::move(devices);
    info.layers = LayerSet::all();  // but those that only some methods have something to say of
    for (const Layer layer : {Layer::PhotonCount, Layer::Overlap, Layer::Clamped, Layer::Voxels, Layer::Vpls,
                              Layer::SplitNormal, Layer::SplitIndirect})
        info.layers.remove(layer);
    info.make_params = +[]() -> std::unique_ptr<MethodParams> { return std::make_unique<typename M::Params>(); };
    info.make = nullptr;
    info.make_gpu = nullptr;
    info.estimate_bytes = nullptr;
    info.estimate_bytes_gpu = nullptr;
    info.estimate_device_bytes = nullptr;
    info.check_gpu = +[](const MethodParams&) {};
    info.estimate_artefact_bytes = +[](const MethodParams&, const Workload&) { return uint64_t{0}; };
    return info;
}

/// With a class for the CPU.
template <class M>
MethodInfo row(std::string_view title, std::string_view family, std::vector<std::string_view> sources,
               std::vector<std::string_view> devices) {
    MethodInfo info = described<M>(title, family, std::move(sources), std::move(devices));
    info.make = +[](const MethodParams& params) -> std::unique_ptr<Method> {
        return std::make_unique<M>(dynamic_cast<const typename M::Params&>(params));
    };
    info.estimate_bytes = +[](const MethodParams& params, const Workload& workload) {
        return M::estimate_bytes(dynamic_cast<const typename M::Params&>(params), workload);
    };
    return info;
}

/// The same with a class for the GPU; `Named`: the one that names the parameters.
template <class Named, class Gpu>
MethodInfo on_gpu(MethodInfo info) {
    info.make_gpu = +[](const MethodParams& params) -> std::unique_ptr<Method> {
        return std::make_unique<Gpu>(dynamic_cast<const typename Named::Params&>(params));
    };
    if constexpr (requires(const typename Named::Params& params) { Gpu::check_gpu(params); })
        info.check_gpu =
            +[](const MethodParams& params) { Gpu::check_gpu(dynamic_cast<const typename Named::Params&>(params)); };
    info.estimate_bytes_gpu = +[](const MethodParams& params, const Workload& workload) {
        return Gpu::estimate_bytes(dynamic_cast<const typename Named::Params&>(params), workload);
    };
    info.estimate_device_bytes = +[](const MethodParams& params, const Workload& workload) {
        return Gpu::estimate_device_bytes(dynamic_cast<const typename Named::Params&>(params), workload);
    };
    return info;
}

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

MethodInfo photon_mapping_row() {
    MethodInfo info = on_gpu<PhotonMapping, PhotonMappingGpu>(
        row<PhotonMapping>("Photon mapping", "photon mapping",
                           {"Jensen 1996, Global Illumination using Photon Maps",
                            "Jensen 1995, Importance Driven Path Tracing using the Photon Map",
                            "Jensen and Christensen 1995, Efficiently Rendering Shadows using the Photon Map",
                            "Christensen 1999, Faster Photon Map Global Illumination"},
                           {"cpu", "gpu"}));
    info.layers.add(Layer::PhotonCount);
    info.artefacts = {{PhotonMapping::kArtefact, "model/gltf-binary", "keep_photon_map", "photon map"}};
    info.estimate_artefact_bytes = photon_map_file_bytes;
    return info;
}

MethodInfo photon_splatting_row() {
    MethodInfo info = on_gpu<PhotonSplatting, PhotonSplattingGpu>(row<PhotonSplatting>(
        "Photon splatting", "photon splatting",
        {"the thesis papers/photon-splatting.txt", "Dachsbacher and Stamminger 2006, Splatting Indirect Illumination",
         "Kollig and Keller 2004, Illumination in the Presence of Weak Singularities"},
        {"cpu", "gpu"}));
    info.layers.add(Layer::Overlap);
    info.layers.remove(Layer::Caustic);
    return info;
}

MethodInfo svo_many_lights_row() {
    MethodInfo info = on_gpu<SvoManyLights, SvoManyLightsGpu>(
        row<SvoManyLights>("Many lights, sparse voxel octree", "many lights",
                           {"the thesis papers/svo-many-lights.txt", "Keller 1997, Instant Radiosity",
                            "Kollig and Keller 2004, Illumination in the Presence of Weak Singularities",
                            "Clarberg et al. 2005, Wavelet Importance Sampling"},
                           {"cpu", "gpu"}));
    for (const Layer layer : {Layer::Clamped, Layer::Voxels, Layer::Vpls, Layer::SplitNormal, Layer::SplitIndirect})
        info.layers.add(layer);
    info.layers.remove(Layer::Caustic);
    return info;
}

/// Runs on GPUs alone, and tells no caustics apart.
template <class Gpu>
MethodInfo gpu_row(std::string_view title, std::vector<std::string_view> sources) {
    MethodInfo info = on_gpu<Gpu, Gpu>(described<Gpu>(title, "many lights", std::move(sources), {"gpu"}));
    info.layers.remove(Layer::Caustic);
    return info;
}

}  // namespace

std::span<const MethodInfo> all_methods() {
    static const MethodInfo kMethods[] = {
        gpu_row<ImperfectShadowMapsGpu>(
            "Imperfect shadow maps",
            {"Ritschel et al. 2008, Imperfect Shadow Maps for Efficient Computation of Indirect Illumination",
             "Marroquim et al. 2007, Efficient Point-Based Rendering Using Image Reconstruction"}),
        on_gpu<PathTracing, PathTracingGpu>(row<PathTracing>(
            "Path tracing", "path tracing",
            {"Kajiya 1986, The Rendering Equation", "Veach 1997, Robust Monte Carlo Methods"}, {"cpu", "gpu"})),
        photon_mapping_row(),
        photon_splatting_row(),
        gpu_row<ReflectiveShadowMapsGpu>("Reflective shadow maps",
                                         {"Dachsbacher and Stamminger 2005, Reflective Shadow Maps"}),
        svo_many_lights_row(),
    };
    return kMethods;
}

const ArtefactInfo* MethodInfo::find_artefact(std::string_view artefact_name) const {
    for (const ArtefactInfo& artefact : artefacts)
        if (artefact.name == artefact_name) return &artefact;
    return nullptr;
}

std::vector<std::string> MethodInfo::layers_on_request() const {
    std::vector<std::string> names;
    for (const LayerInfo& info : kLayers)
        if (layers.has(info.layer) && !LayerSet().has(info.layer)) names.emplace_back(info.name);
    return names;
}

std::span<const ArtefactInfo> all_artefacts() {
    static const std::vector<ArtefactInfo> kArtefacts = [] {
        std::vector<ArtefactInfo> all;
        for (const MethodInfo& method : all_methods())
            for (const ArtefactInfo& artefact : method.artefacts)
                if (std::none_of(all.begin(), all.end(),
                                 [&](const auto& known) { return known.name == artefact.name; }))
                    all.push_back(artefact);
        return all;
    }();
    return kArtefacts;
}

const MethodInfo* find_method(std::string_view name) {
    for (const MethodInfo& method : all_methods())
        if (method.name == name) return &method;
    return nullptr;
}

}  // namespace photond
