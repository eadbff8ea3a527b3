// What the house asks of this method.

#include "renderer/bidirectional/bidirectional_row.h"
#include "renderer/methods/bidirectional_path_tracing/bidirectional_path_tracing.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const BidirectionalParams& params, const Needs& needs) {
    const uint32_t bounces = bounces_of_scatterings(params.max_scatterings());
    if (params.light_paths == 0.0f) return left_out_by_eye_paths(bounces, needs);
    PathsLeftOut left_out = left_out_by_two_paths(bounces, needs);
    // What mirrors show of what caustics light is connected, or not made at all.
    if (params.connections == Connections::Cache && params.connections_per_vertex == 0u &&
        has_delta_light_by_delta(needs))
        left_out.add(PathKind::DeltaLightAfterCaustics);
    return left_out;
}

}  // namespace

MethodInfo bidirectional_path_tracing_row();

MethodInfo bidirectional_path_tracing_row() {
    MethodInfo info = bidirectional_row<BidirectionalPathTracing, void>();
    info.left_out = left_out_of<BidirectionalParams, paths_left_out>;
    info.title = "Bidirectional path tracing";
    info.line =
        "Follows light from the eye and from the lamps, and joins both. Unbiased; good where light comes by detours.";
    info.sources = {{"Veach and Guibas", 1995, "Bidirectional Estimators for Light Transport"},
                    {"Lafortune and Willems", 1993, "Bi-Directional Path Tracing"},
                    {"Davidovic et al.", 2014, "Progressive Light Transport Simulation on the GPU"}};
    return info;
}

}  // namespace photond
