#include "renderer/many_lights/camera_importance_gpu.h"

#include <algorithm>

namespace photond {

CameraImportanceGpu::CameraImportanceGpu(const gpu::DeviceScene& scene, GBufferGpu& buffer, SparseVoxelOctreeGpu* tree,
                                         uint64_t seed, float clamp_sq_m2, uint32_t texels)
    : buffer_(buffer),
      tree_(tree),
      seed_(seed),
      clamp_sq_m2_(clamp_sq_m2),
      texels_(texels),
      texels_at_once_(std::max(scene.device().paths_per_submit() / CAMERA_IMPORTANCE_POINTS, 1024u)),
      pipeline_(scene.device(), "renderer/many_lights/camera_importance.comp", sizeof(gpu::CameraImportancePush),
                nullptr, {gpu::specialize(IMPORTANCE_HAS_TREE_ID, tree != nullptr)}) {}

void CameraImportanceGpu::record(gpu::CommandList& commands, gpu::Buffer& texels, gpu::Buffer& importance,
                                 uint32_t pass, uint32_t piece) {
    const uint32_t first = piece * texels_at_once_, end = std::min(first + texels_at_once_, texels_);
    const gpu::Scope scope(commands, "rsm");
    gpu::Buffer& unread = buffer_.eye();
    commands.bind(pipeline_, {gpu::read("points", buffer_.points()), gpu::read("texels", texels),
                              gpu::read_write("importance", importance),
                              gpu::read("svo_constants", tree_ ? tree_->constants() : unread),
                              gpu::read("svo_nodes", tree_ ? tree_->nodes() : unread),
                              gpu::read("svo_bricks", tree_ ? tree_->bricks() : unread)});
    commands.push(gpu::CameraImportancePush{.seed = seed_,
                                            .pass = pass,
                                            .points = buffer_.layout().points(),
                                            .first_texel = first,
                                            .end_texel = end,
                                            .clamp_sq_m2 = clamp_sq_m2_});
    commands.dispatch_threads(end - first, CAMERA_IMPORTANCE_GROUP);
}

}  // namespace photond
