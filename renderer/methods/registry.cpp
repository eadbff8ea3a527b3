#include "renderer/methods/registry.h"

#include <algorithm>

#include "renderer/methods/path_tracing/path_tracing.h"

namespace photond {

namespace {

/// A row for a method whose class names its parameters `Params`.
template <class M>
MethodInfo row(std::string_view title, std::string_view family, std::vector<std::string_view> sources,
               std::vector<std::string_view> devices) {
    MethodInfo info;
    info.name = M::kName;
    info.title = title;
    info.family = family;
    info.sources = std::move(sources);
    info.devices = std::move(devices);
    info.layers = LayerSet::all();
    info.layers.remove(Layer::PhotonCount);  // of methods that have photons to count
    info.make_params = +[]() -> std::unique_ptr<MethodParams> { return std::make_unique<typename M::Params>(); };
    info.make = +[](const MethodParams& params) -> std::unique_ptr<Method> {
        return std::make_unique<M>(dynamic_cast<const typename M::Params&>(params));
    };
    info.estimate_bytes = +[](const MethodParams& params, const Workload& workload) {
        return M::estimate_bytes(dynamic_cast<const typename M::Params&>(params), workload);
    };
    info.estimate_artefact_bytes = +[](const MethodParams&, const Workload&) { return uint64_t{0}; };
    return info;
}

}  // namespace

std::span<const MethodInfo> all_methods() {
    static const MethodInfo kMethods[] = {
        row<PathTracing>("Path tracing", "path tracing",
                         {"Kajiya 1986, The Rendering Equation", "Veach 1997, Robust Monte Carlo Methods"}, {"cpu"}),
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
