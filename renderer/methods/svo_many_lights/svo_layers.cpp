#include "renderer/methods/svo_many_lights/svo_layers.h"

#include "renderer/core/parallel.h"
#include "renderer/core/rng.h"
#include "renderer/many_lights/vpl_set_shared.h"
#include "renderer/scene/camera_projection.h"

namespace photond {

namespace {

/// Of a brick: bright, and told apart from its neighbours.
Rgb brick_color(const uvec3& voxel) {
    const uvec3 brick = voxel / uint32_t{BRICK_SIDE};
    const uint32_t bits = hash32(brick.x | brick.y << 8 | brick.z << 16);
    const auto channel = [&](uint32_t shift) { return 0.4f + 0.6f * static_cast<float>(bits >> shift & 0xffu) / 255; };
    return {channel(0), channel(8), channel(16)};
}

/// Cosine between the ray and the face of the voxel it enters by.
float face_cosine(const gpu::VoxelGrid& grid, const VoxelHit& hit, const Ray& ray) {
    const vec3 centre = grid.low + (vec3(hit.voxel) + 0.5f) * grid.cell_m;
    const vec3 from = glm::abs(ray.origin + hit.t * ray.direction - centre);
    const int axis = from.x >= from.y && from.x >= from.z ? 0 : from.y >= from.z ? 1 : 2;
    return std::fabs(ray.direction[axis]);
}

}  // namespace

void show_voxels(const SvoView& tree, const EyeScene& eye, std::vector<Rgb>& layer) {
    const uint32_t width = eye.view.film_size.width;
    parallel_for(layer.size(), 256, [&](size_t pixel) {
        const size_t row = pixel / width, column = pixel % width;
        const vec2 place(static_cast<float>(column), static_cast<float>(row));
        const Ray ray = eye.camera_rays(place + 0.5f, vec2(0.5f));
        VoxelHit hit;
        layer[pixel] = svo_first_voxel(tree, ray, hit)
                           ? brick_color(hit.voxel) * face_cosine(tree.constants.grid, hit, ray)
                           : Rgb(0);
    });
}

void show_vpls(std::span<const Vpl> vpls, const EyeScene& eye, const GBuffer& buffer, std::vector<float>& layer) {
    const Size2 size = eye.view.film_size;
    for (const Vpl& vpl : vpls) {
        const std::optional<vec2> film = project(eye.camera_rays, vpl.position);
        if (!film || !(film->x >= 0 && film->y >= 0)) continue;
        if (!(film->x < static_cast<float>(size.width) && film->y < static_cast<float>(size.height))) continue;
        const auto x = static_cast<uint32_t>(film->x), y = static_cast<uint32_t>(film->y);
        const gpu::GBufferPoint& shown = buffer.points()[buffer.layout().point_of(x, y)];
        const float depth_m = glm::dot(vpl.position - eye.view.camera.position, eye.view.camera.forward);
        if (shown.kind != 0 && std::fabs(depth_m - shown.depth_m) <= VPL_SHOWN_DEPTH * shown.depth_m)
            layer[size_t{y} * size.width + x] += 1;
    }
}

}  // namespace photond
