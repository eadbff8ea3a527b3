#include "renderer/methods/photon_splatting/splat_depth_atlas.h"

#include <algorithm>

#include "renderer/backends/gpu/bvh.h"
#include "renderer/methods/photon_splatting/splat_depth_shared.h"
#include "renderer/methods/photon_splatting/splat_shared.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr const char* kStructure = "depth_atlas";
constexpr uint32_t kSide = 2048;                                         // of an atlas, at most
constexpr uint64_t kMostTexels = MOST_DEPTH_TEXELS * MOST_DEPTH_TEXELS;  // of a map

uint32_t most_columns(uint32_t resolution) { return std::max(kSide / resolution, 1u); }

/// Of one atlas. A software device draws few at a time, so that cancelling is answered soon.
uint32_t splats_of_atlas(uint32_t resolution, uint32_t splats) {
    return std::clamp(splats, 1u, most_columns(resolution) * most_columns(resolution));
}
uint32_t splats_of_draw(const gpu::Device& device, uint64_t triangles, uint32_t resolution, uint32_t splats) {
    const uint64_t of_splat = std::max<uint64_t>(3 * triangles, uint64_t{resolution} * resolution);
    const uint64_t most = std::max<uint64_t>(device.paths_per_submit() / of_splat, 1);
    return static_cast<uint32_t>(std::min<uint64_t>(splats_of_atlas(resolution, splats), most));
}
uint32_t rows(uint32_t splats, uint32_t columns) { return (splats + columns - 1) / columns; }

}  // namespace

bool SplatDepthAtlas::possible(const Scene& scene) {
    return !scene.needs.alpha && !gpu::has_two_levels(scene) && scene.triangle_count > 0 &&
           scene.triangle_count < UINT32_MAX / 3;
}

bool SplatDepthAtlas::faster(const Needs& needs, uint64_t triangles, uint32_t resolution) {
    // lavapipe, microseconds a splat, traced and drawn: 32 triangles (cornell-box) at 8^2 texels 16 and 8, at 16^2 40
    // and 18, at 32^2 137 and 52, at 64^2 570 and 400; 263,112 (interior) at 32^2 300 and 24,000, at 64^2 1000 and
    // 24,000. So a triangle that is clipped away costs 0.09, a ray 0.14 to 0.3, a texel drawn 0.03 to 0.1.
    static_assert(kMostTexels < gpu::kMostCopiedTriangles, "so few are never in trees of their own");
    return !needs.alpha && triangles > 0 && triangles <= uint64_t{resolution} * resolution;
}

uint64_t SplatDepthAtlas::device_bytes(uint32_t resolution, uint32_t splats) {
    const uint64_t texels = uint64_t{resolution} * resolution;
    return 2 * splats_of_atlas(resolution, splats) * texels * sizeof(float);  // the image and its copy
}

SplatDepthAtlas::SplatDepthAtlas(const gpu::DeviceScene& scene, uint32_t resolution, uint32_t splats)
    : resolution_(resolution),
      triangles_(static_cast<uint32_t>(scene.scene().triangle_count)),
      splats_at_once_(splats_of_draw(scene.device(), triangles_, resolution, splats)),
      columns_(std::min(splats_at_once_, most_columns(resolution))),
      rows_(rows(splats_at_once_, columns_)),
      atlas_(scene.device(), kStructure, VK_FORMAT_D32_SFLOAT, columns_ * resolution, rows_ * resolution),
      depths_(scene.device(), kStructure, atlas_.packed_bytes()),
      draw_(scene.device(), "renderer/methods/photon_splatting/splat_depth_atlas.vert",
            "renderer/methods/photon_splatting/splat_depth_atlas.frag", sizeof(gpu::SplatDepthPush), {.depth = true},
            &scene.set()),
      spread_(scene.device(), "renderer/methods/photon_splatting/splat_depth_atlas.comp", sizeof(gpu::SplatDepthPush)) {
}

void SplatDepthAtlas::record(gpu::CommandList& commands, gpu::Buffer& constants, gpu::Buffer& splats,
                             gpu::Buffer& depth_maps, uint32_t first, uint32_t end) {
    const gpu::SplatDepthPush push{first, end, columns_, rows_};
    {
        gpu::RasterPass pass(commands, draw_, {{}, gpu::clear_depth(atlas_)}, {gpu::read("splats", splats)});
        pass.push(push);
        pass.draw(3 * triangles_, end - first);
    }
    gpu::copy(commands, atlas_, depths_);
    commands.bind(spread_, {gpu::read("constants", constants), gpu::read("splats", splats), gpu::read("atlas", depths_),
                            gpu::write("farthest_m", depth_maps)});
    commands.push(push);
    commands.dispatch_threads(uint64_t{end - first} * resolution_ * resolution_, SPLAT_GROUP);
}

}  // namespace photond
