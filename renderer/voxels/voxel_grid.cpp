#include "renderer/voxels/voxel_grid.h"

#include <algorithm>
#include <bit>

#include "protocol/error.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr double kLeastSpacings = 4;  // of the greatest coordinate's floats, that a voxel is long
constexpr double kLeastCell = 1e-30;  // [m], whose inverse in sub-units is a float
constexpr float kFarUnits = 0x1p19f;

/// The product rounded to single precision by itself: the compiler may not fuse it with a sum.
float product(float a, float b) {
    const volatile float rounded = a * b;
    return rounded;
}

/// GLSL twin: voxel_world_position() (voxel_grid.glsl).
vec3 world_position(const Instance& instance, const vec3& p) {
    if (instance.identity) return p;
    const mat4x3& m = instance.to_world;
    vec3 world;
    for (int i = 0; i < 3; ++i)
        world[i] = product(m[0][i], p.x) + product(m[1][i], p.y) + product(m[2][i], p.z) + m[3][i];
    return world;
}

}  // namespace

double least_cell_m(const Bounds3& bounds) {
    if (bounds.empty()) return kLeastCell;
    const dvec3 farthest = glm::max(glm::abs(dvec3(bounds.min)), glm::abs(dvec3(bounds.max)));
    const double spacing = std::max({farthest.x, farthest.y, farthest.z}) * 0x1p-23;
    return std::max(kLeastSpacings * spacing, kLeastCell);
}

VoxelGrid make_voxel_grid(const Bounds3& bounds, uint32_t resolution) {
    if (resolution < VOXEL_LEAST_RESOLUTION || resolution > VOXEL_MOST_RESOLUTION || !std::has_single_bit(resolution))
        throw Error(ErrorCode::OutOfRange, "resolution",
                    "resolution = " + std::to_string(resolution) + " is no power of two within [" +
                        std::to_string(VOXEL_LEAST_RESOLUTION) + ", " + std::to_string(VOXEL_MOST_RESOLUTION) + "]");
    const dvec3 low(bounds.empty() ? vec3(0) : bounds.min), high(bounds.empty() ? vec3(0) : bounds.max);
    const dvec3 diagonal = high - low;
    double extent = std::max({diagonal.x, diagonal.y, diagonal.z});
    if (!(extent > 0)) extent = 1;
    const double cell = std::max(extent / (resolution - 2), least_cell_m(bounds));
    const auto cell_m = static_cast<float>(cell * (1 + 1e-6));
    return {vec3(0.5 * (low + high) - 0.5 * double{cell_m} * resolution), cell_m, resolution};
}

gpu::SvoConstants svo_constants_of(const VoxelGrid& grid) {
    const float voxels_per_m = 1 / grid.cell_m;
    return {.grid = grid,
            .voxels_per_m = voxels_per_m,
            .units_per_m = VOXEL_UNITS * voxels_per_m,
            .levels = static_cast<uint32_t>(std::countr_zero(grid.resolution / BRICK_SIDE)),
            .surface_base = 0,
            .instance_count = 0,
            .triangle_count = 0};
}

glm::ivec3 quantise(const gpu::SvoConstants& constants, const vec3& position) {
    glm::ivec3 units;
    for (int i = 0; i < 3; ++i) {
        const float at = product(position[i] - constants.grid.low[i], constants.units_per_m);
        units[i] = static_cast<int>(std::floor(std::clamp(at, -kFarUnits, kFarUnits) + 0.5f));
    }
    return units;
}

QuantisedTriangle quantised_triangle(const gpu::SvoConstants& constants, const Scene& scene, uint32_t instance,
                                     uint32_t triangle) {
    const Instance& placed = scene.instances[instance];
    const Mesh& mesh = scene.meshes[placed.mesh];
    const uvec3 corner = mesh.triangles[triangle];
    QuantisedTriangle quantised;
    for (int i = 0; i < 3; ++i)
        quantised.p[static_cast<size_t>(i)] = quantise(constants, world_position(placed, mesh.positions[corner[i]]));
    return quantised;
}

bool is_voxelised(const Material& material) {
    switch (material.alpha_mode) {
        case AlphaMode::Opaque: return true;
        case AlphaMode::Mask: return material.alpha >= material.alpha_cutoff;
        case AlphaMode::Blend: return material.alpha >= 0.5f;
    }
    return true;
}

std::vector<uint32_t> first_triangles_of(const Scene& scene) {
    std::vector<uint32_t> first = {0};
    uint64_t count = 0;
    for (const Instance& instance : scene.instances) {
        count += scene.meshes[instance.mesh].triangles.size();
        if (count >= UINT32_MAX) throw Error(ErrorCode::OutOfMemory, "too many triangles for 32-bit voxel surfaces");
        first.push_back(static_cast<uint32_t>(count));
    }
    return first;
}

}  // namespace photond
