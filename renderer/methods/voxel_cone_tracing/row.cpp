// What the house asks of this method.

#include "renderer/frame/method_row.h"
#include "renderer/methods/voxel_cone_tracing/voxel_cone_tracing_gpu.h"

namespace photond {

namespace {

PathsLeftOut paths_left_out(const VoxelConeTracingParams& params, const Needs& needs) {
    return left_out_by_connections(params.bounces, params.glossy_threshold, params.connect_threshold, needs);
}

}  // namespace

MethodInfo voxel_cone_tracing_row();

MethodInfo voxel_cone_tracing_row() {
    MethodInfo info = row_of_classes<void, VoxelConeTracingGpu>();
    info.left_out = left_out_of<VoxelConeTracingParams, paths_left_out>;
    info.title = "Voxel cone tracing";
    info.line = "Cones through a filtered voxel octree with light in it. For real time, all bounces and gloss; leaks.";
    info.family = "voxels";
    info.sources = {{"Crassin et al.", 2011, "Interactive Indirect Illumination Using Voxel Cone Tracing"}};
    info.layers.add(Layer::ConeMip);
    info.layers.remove(Layer::Caustic);
    info.limits = {{{}, "", "five cones see the mean of cells: shadows are soft, and near things are not seen"},
                   {{}, "thin wall", "a cell about a wall has what is before it and behind it"}};
    return info;
}

}  // namespace photond
