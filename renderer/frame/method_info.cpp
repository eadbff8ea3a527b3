#include "renderer/frame/method_info.h"

namespace photond {

std::string Source::text() const {
    std::string text(author);
    if (year != 0) text += " " + std::to_string(year);
    return text.append(", ").append(title);
}

std::vector<std::string_view> MethodInfo::devices() const {
    std::vector<std::string_view> kinds;
    if (make) kinds.emplace_back("cpu");
    if (make_gpu) kinds.emplace_back("gpu");
    return kinds;
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

}  // namespace photond
