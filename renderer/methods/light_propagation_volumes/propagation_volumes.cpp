#include "renderer/methods/light_propagation_volumes/propagation_volumes.h"

#include <algorithm>

#include "renderer/voxels/voxel_grid.h"

namespace photond {

namespace {

constexpr double kBehindEye = 0.25;  // of a finer grid's side

gpu::PropagationGrid coarsest_grid(const Bounds3& bounds, uint32_t resolution) {
    const dvec3 low(bounds.empty() ? vec3(0) : bounds.min), high(bounds.empty() ? vec3(0) : bounds.max);
    const dvec3 sides = high - low;
    double longest = std::max({sides.x, sides.y, sides.z});
    if (!(longest > 0)) longest = 1;
    const auto cell_m = static_cast<float>(std::max(longest / (resolution - 2), least_cell_m(bounds)) * (1 + 1e-6));
    gpu::PropagationGrid grid{};
    grid.cell_m = cell_m;
    for (int axis = 0; axis < 3; ++axis)
        grid.cells[axis] = std::min(static_cast<uint32_t>(std::ceil(sides[axis] / double{cell_m})) + 2, resolution);
    grid.low = vec3(0.5 * (low + high) - 0.5 * double{cell_m} * dvec3(grid.cells));
    return grid;
}

gpu::PropagationGrid finer_grid(const gpu::PropagationGrid& coarse, const Camera& camera) {
    gpu::PropagationGrid grid = coarse;
    grid.cell_m = 0.5f * coarse.cell_m;
    for (int axis = 0; axis < 3; ++axis) {
        const double side_m = double{grid.cell_m} * grid.cells[axis];
        const double ahead = (0.5 - kBehindEye) * side_m * double{camera.forward[axis]};
        const double wanted = double{camera.position[axis]} + ahead - 0.5 * side_m;
        const double cells_in = std::round((wanted - double{coarse.low[axis]}) / double{coarse.cell_m});
        const uint32_t half = coarse.cells[axis] / 2;
        const double most = coarse.cells[axis] - half;  // of an odd number, half a cell juts out
        grid.low[axis] = coarse.low[axis] + coarse.cell_m * static_cast<float>(std::clamp(cells_in, 0.0, most));
    }
    return grid;
}

}  // namespace

gpu::PropagationCascades make_propagation_cascades(const Bounds3& bounds, const Camera& camera, uint32_t resolution,
                                                   uint32_t cascades) {
    gpu::PropagationCascades all{};
    all.count = cascades;
    all.grids[0] = coarsest_grid(bounds, resolution);
    for (uint32_t i = 1; i < cascades; ++i) all.grids[i] = finer_grid(all.grids[i - 1], camera);
    const glm::uvec3 cells = all.grids[0].cells;
    all.cells = cells.x * cells.y * cells.z;
    all.faces = (cells.x + 1) * (cells.y + 1) * (cells.z + 1);
    return all;
}

}  // namespace photond
