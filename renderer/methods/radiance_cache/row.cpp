// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/radiance_cache/radiance_cache.h"
#include "renderer/methods/radiance_cache/radiance_cache_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out_by_cached_paths(const RadianceCacheParams& params, const Needs& needs) {
    return left_out_by_eye_paths(bounces_of_scatterings(params.max_scatterings()), needs);
}

}  // namespace

MethodInfo radiance_cache_row();

MethodInfo radiance_cache_row() {
    MethodInfo info = row_of_classes<RadianceCache, RadianceCacheGpu>();
    info.left_out = left_out_of<RadianceCacheParams, paths_left_out_by_cached_paths>;
    info.title = "Radiance cache";
    info.line =
        "Paths from the eye end early, in a hash grid of what they found before. Clean soon; blurred by its cells.";
    info.estimate_artefact_bytes = +[](const MethodParams& params, const Workload& /*workload*/) -> uint64_t {
        const auto& own = dynamic_cast<const RadianceCacheParams&>(params);
        return own.aged ? 2 * LeftCells::bytes_for(own.cells) : 0;  // a film that is saved again lies beside the last
    };
    info.family = "path tracing";
    info.sources = {
        {"Binder et al.", 2018, "Fast Path Space Filtering by Jittered Spatial Hashing"},
        {"Müller et al.", 2021, "Real-time Neural Radiance Caching for Path Tracing"},
        {"Boissé et al.", 2023,
         "GI-1.0: A Fast and Scalable Two-level Radiance Caching Scheme for Real-Time Global Illumination"}};
    for (const Layer layer : {Layer::CacheCells, Layer::CacheSamples}) info.layers.add(layer);
    info.bias_falls_with = {{{"shrink", "true"}}};
    return info;
}

}  // namespace photond
