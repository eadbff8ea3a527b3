// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/visibility_filtering/visibility_filtering_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out_by_proxies(const VisibilityFilteringParams& params, const Needs& needs) {
    return left_out_by_connections(params.bounces, params.glossy_threshold, params.glossy_threshold, needs);
}

}  // namespace

MethodInfo visibility_filtering_row();

MethodInfo visibility_filtering_row() {
    MethodInfo info = row_of_classes<void, VisibilityFilteringGpu>();
    info.left_out = left_out_of<VisibilityFilteringParams, paths_left_out_by_proxies>;
    info.title = "Visibility filtering";
    info.line = "Points on surfaces send on light; sparse rays say from where it is seen. For real time, one bounce.";
    info.family = "many lights";
    info.estimate_artefact_bytes = +[](const MethodParams& params, const Workload& workload) -> uint64_t {
        const auto& own = dynamic_cast<const VisibilityFilteringParams&>(params);
        if (own.kept_lists == 0) return 0;
        return 2 * LeftLists::bytes_for(KeptLayout(workload.film_size, own));  // a film that is saved again lies beside
    };
    info.sources = {{"Chen et al.", 2014, "Visibility Filtering for Producing Indirect Illumination"}};
    info.layers.remove(Layer::Caustic);
    for (const Layer layer : {Layer::Proxies, Layer::ProxyVoxels, Layer::VisibilityCount, Layer::ListsBeforeFilter,
                              Layer::UpsamplingWeight})
        info.layers.add(layer);
    info.bias_falls_with = {{{"shrink", "true"}, {"visibility", "rays"}, {"subsampling", "1"}}};
    constexpr const char* kWhole = "a voxel of proxies is seen wholly or not at all";
    constexpr const char* kShares = "how much of a voxel is seen, a window of pixels and few rays tell";
    for (const char* visibility : {"discs", "svo"}) {
        for (const char* lists : {"bits", "indices"})
            info.limits.push_back({{{"visibility", visibility}, {"lists", lists}}, "", kWhole});
        info.limits.push_back({{{"visibility", visibility}}, "", kShares});
    }
    info.limits.push_back(
        {{},
         "",
         "light of near proxies is softened, that of far voxels smooth, and gloss sends it on as if it were Lambert"});
    return info;
}

}  // namespace photond
