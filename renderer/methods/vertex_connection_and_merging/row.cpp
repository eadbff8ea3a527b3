// What the house asks of this method.

#include "renderer/bidirectional/bidirectional_method_gpu.h"
#include "renderer/bidirectional/bidirectional_row.h"
#include "renderer/methods/vertex_connection_and_merging/vertex_connection_and_merging.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const VertexConnectionAndMergingParams& params, const Needs& needs) {
    const uint32_t bounces = bounces_of_scatterings(params.max_scatterings());
    return params.light_paths == 0.0f ? left_out_by_eye_paths(bounces, needs) : PathsLeftOut(bounces, needs);
}

}  // namespace

MethodInfo vertex_connection_and_merging_row();

MethodInfo vertex_connection_and_merging_row() {
    MethodInfo info = bidirectional_row<VertexConnectionAndMerging, BidirectionalTwinGpu<VertexConnectionAndMerging>>();
    info.left_out = left_out_of<VertexConnectionAndMergingParams, paths_left_out>;
    info.title = "Vertex connection and merging";
    info.line =
        "Bidirectional path tracing and photon mapping, each where it is the better. Hidden lamps and caustics, in "
        "mirrors too; biased while its radius shrinks.";
    info.layers.add(Layer::Merges);
    info.bias_falls_with.emplace();
    info.sources = {
        {"Georgiev et al.", 2012, "Light Transport Simulation with Vertex Connection and Merging"},
        {"Hachisuka, Pantaleoni and Jensen", 2012, "A Path Space Extension for Robust Light Transport Simulation"},
        {"Grittmann, Georgiev and Slusallek", 2021,
         "Correlation-Aware Multiple Importance Sampling for Bidirectional Rendering Algorithms"}};
    return info;
}

}  // namespace photond
