// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/path_tracing/path_tracing.h"
#include "renderer/methods/path_tracing/path_tracing_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const PathTracingParams& params, const Needs& needs) {
    return left_out_by_eye_paths(bounces_of_scatterings(params.max_scatterings()), needs);
}

}  // namespace

MethodInfo path_tracing_row();

MethodInfo path_tracing_row() {
    MethodInfo info = row_of_classes<PathTracing, PathTracingGpu>();
    info.left_out = left_out_of<PathTracingParams, paths_left_out>;
    info.title = "Path tracing";
    info.line =
        "Follows light backwards from the eye. Unbiased, the measure for the others; caustics are noisy for long.";
    info.family = "path tracing";
    info.sources = {{"Kajiya", 1986, "The Rendering Equation"}, {"Veach", 1997, "Robust Monte Carlo Methods"}};
    return info;
}

}  // namespace photond
