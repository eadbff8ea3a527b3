#include "server/job_vocabulary.h"

#include "renderer/error/metric.h"
#include "renderer/methods/registry.h"

namespace photond {

JobVocabulary job_vocabulary() {
    JobVocabulary vocabulary;
    for (const MethodInfo& method : all_methods()) vocabulary.method_names.emplace_back(method.name);
    for (const LayerInfo& info : kLayers) {
        (LayerSet().has(info.layer) ? vocabulary.always_layers : vocabulary.layer_names).emplace_back(info.name);
        if (info.radiance()) vocabulary.radiance_layers.emplace_back(info.name);
    }
    for (const MetricInfo& metric : kMetrics) {
        if (metric.values != 1) continue;
        vocabulary.metric_names.emplace_back(metric.name);
        if (!metric.needs_reference) vocabulary.estimated_metrics.emplace_back(metric.name);
    }
    vocabulary.make_params = [](const std::string& method) -> std::unique_ptr<MethodParams> {
        const MethodInfo* info = find_method(method);
        return info ? info->make_params() : nullptr;
    };
    vocabulary.devices_of = [](const std::string& method) {
        std::vector<std::string> kinds;
        if (const MethodInfo* info = find_method(method)) {
            const std::vector<std::string_view> devices = info->devices();
            kinds.assign(devices.begin(), devices.end());
        }
        return kinds;
    };
    vocabulary.layers_of = [](const std::string& method) {
        const MethodInfo* info = find_method(method);
        return info ? info->layers_on_request() : std::vector<std::string>();
    };
    return vocabulary;
}

}  // namespace photond
