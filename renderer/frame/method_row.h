#pragma once
// A method's classes as the functions of its row. Only a room's row.cpp needs this.

#include <type_traits>

#include "renderer/frame/common_params.h"
#include "renderer/frame/method_info.h"

namespace photond {

namespace method_row_detail {

template <class Params>
const Params& as(const MethodParams& params) {
    return dynamic_cast<const Params&>(params);
}

}  // namespace method_row_detail

/// A row with what follows from the classes alone. `Cpu`: runs on the CPU; `Gpu`: on a GPU; void where there is none.
/// Its layers are those that every method can fill (LayerFilledBy::All).
template <class Cpu, class Gpu>
MethodInfo row_of_classes() {
    constexpr bool kHasCpu = !std::is_void_v<Cpu>, kHasGpu = !std::is_void_v<Gpu>;
    using Named = std::conditional_t<kHasCpu, Cpu, Gpu>;  // names method and parameters
    using Params = typename Named::Params;
    using method_row_detail::as;
    MethodInfo info;
    info.name = Named::kName;
    for (const LayerInfo& layer : kLayers)
        if (layer.filled_by == LayerFilledBy::All) info.layers.add(layer.layer);
    info.make_params = +[]() -> std::unique_ptr<MethodParams> { return std::make_unique<Params>(); };
    info.check_gpu = +[](const MethodParams&) {};
    info.estimate_artefact_bytes = +[](const MethodParams&, const Workload&) { return uint64_t{0}; };
    if constexpr (requires(const Params& params) { params.temporal.history_cap; }) {
        info.temporal = +[](const MethodParams& params) { return &as<Params>(params).temporal; };
        info.left_to_next = +[](const MethodParams& params) -> std::vector<std::string_view> {
            std::vector<std::string_view> left;
            if (as<Params>(params).temporal.reuse != TemporalReuse::None) left.push_back("indirect light");
            if constexpr (requires(const Params& own) { own.left_beside_light(); })
                for (const std::string_view what : as<Params>(params).left_beside_light()) left.push_back(what);
            return left;
        };
        for (const LayerInfo& layer : kLayers)
            if (layer.filled_by == LayerFilledBy::Following) info.layers.add(layer.layer);
    }
    if constexpr (kHasCpu) {
        info.make = +[](const MethodParams& params) -> std::unique_ptr<Method> {
            return std::make_unique<Cpu>(as<Params>(params));
        };
        info.estimate_bytes = +[](const MethodParams& params, const Workload& workload) {
            return Cpu::estimate_bytes(as<Params>(params), workload);
        };
    }
    if constexpr (kHasGpu) {
        info.make_gpu = +[](const MethodParams& params) -> std::unique_ptr<Method> {
            return std::make_unique<Gpu>(as<Params>(params));
        };
        if constexpr (requires(const Params& params) { Gpu::check_gpu(params); })
            info.check_gpu = +[](const MethodParams& params) { Gpu::check_gpu(as<Params>(params)); };
        if constexpr (requires(const Params& params) { Gpu::traces_on_host(params); })
            info.traces_on_host = +[](const MethodParams& params) { return Gpu::traces_on_host(as<Params>(params)); };
        info.estimate_bytes_gpu = +[](const MethodParams& params, const Workload& workload) {
            return Gpu::estimate_bytes(as<Params>(params), workload);
        };
        info.estimate_device_bytes = +[](const MethodParams& params, const Workload& workload) {
            return Gpu::estimate_device_bytes(as<Params>(params), workload);
        };
    }
    return info;
}

/// MethodInfo::left_out by a function of the method's own parameters.
template <class Params, PathsLeftOut (*kLeftOut)(const Params& params, const Needs& needs)>
PathsLeftOut left_out_of(const MethodParams& params, const Needs& needs) {
    return kLeftOut(method_row_detail::as<Params>(params), needs);
}

}  // namespace photond
