#pragma once
// CameraImportance (camera_importance.h) on a device: the same points, for the texels of a VplTracerGpu.

#include "renderer/backends/gpu/command_list.h"
#include "renderer/backends/gpu/device_scene.h"
#include "renderer/gbuffer/gbuffer_gpu.h"
#include "renderer/many_lights/camera_importance_shared.h"
#include "renderer/voxels/sparse_voxel_octree_gpu.h"

namespace photond {

class CameraImportanceGpu {
public:
    /// Borrows the points and the tree; null: all is seen. `texels`: of a map.
    CameraImportanceGpu(const gpu::DeviceScene& scene, GBufferGpu& buffer, SparseVoxelOctreeGpu* tree, uint64_t seed,
                        float clamp_sq_m2, uint32_t texels);

    /// A map is done in that many pieces, 0 ..., each short enough for one submit; scope `rsm`. `texels` and
    /// `importance`, which is multiplied: VplTracerGpu's.
    uint32_t pieces() const { return (texels_ + texels_at_once_ - 1) / texels_at_once_; }
    void record(gpu::CommandList& commands, gpu::Buffer& texels, gpu::Buffer& importance, uint32_t pass,
                uint32_t piece);

private:
    GBufferGpu& buffer_;
    SparseVoxelOctreeGpu* const tree_;
    const uint64_t seed_;
    const float clamp_sq_m2_;
    const uint32_t texels_, texels_at_once_;
    gpu::ComputePipeline pipeline_;
};

}  // namespace photond
