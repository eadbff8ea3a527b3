#include "renderer/methods/registry.h"

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
    info.make_params = +[]() -> std::unique_ptr<MethodParams> { return std::make_unique<typename M::Params>(); };
    info.make = +[](const MethodParams& params) -> std::unique_ptr<Method> {
        return std::make_unique<M>(dynamic_cast<const typename M::Params&>(params));
    };
    info.estimate_bytes = +[](const MethodParams& params, const Workload& workload) {
        return M::estimate_bytes(dynamic_cast<const typename M::Params&>(params), workload);
    };
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

const MethodInfo* find_method(std::string_view name) {
    for (const MethodInfo& method : all_methods())
        if (method.name == name) return &method;
    return nullptr;
}

}  // namespace photond
