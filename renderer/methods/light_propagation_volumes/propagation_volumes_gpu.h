#pragma once
// Volumes that light propagates in, on a device: what a pass's photons put into them, and where it gets.

#include "renderer/backends/gpu/command_list.h"
#include "renderer/backends/gpu/device_scene.h"
#include "renderer/many_lights/photons_by_cell_gpu.h"
#include "renderer/methods/light_propagation_volumes/propagation_volumes.h"

namespace photond {

class PropagationVolumesGpu {
public:
    /// `most`: photons of a pass. Borrows the scene.
    PropagationVolumesGpu(const gpu::DeviceScene& scene, const gpu::PropagationCascades& cascades, uint32_t most);
    static uint64_t device_bytes(const gpu::PropagationCascades& cascades, uint32_t most);

    /// The geometry volume; waits. `asked`: else every face is open. Stage `voxelise`.
    void find_faces(bool asked, Stats& stats);

    /// The light of a pass as it starts; scope `inject`. Once for each cascade.
    void record_injection(gpu::CommandList& commands, VplTracerGpu& photons, uint32_t cascade);
    /// Steps [first, end) of a cascade's light, the coarser one's being done; scope `propagate`.
    void record_steps(gpu::CommandList& commands, uint32_t cascade, uint32_t first, uint32_t end);

    const gpu::PropagationCascades& cascades() const { return host_cascades_; }
    gpu::Buffer& constants() { return constants_; }  // PropagationCascades
    gpu::Buffer& open_faces() { return faces_; }     // FACE_BITS ...
    gpu::Buffer& injected() { return injected_; }    // CellLight, cascade after cascade
    gpu::Buffer& volume() { return volume_; }        // the same, of what left the cells that it started in

private:
    const gpu::DeviceScene& scene_;
    const gpu::PropagationCascades host_cascades_;
    gpu::Buffer constants_, faces_, injected_, steps_[2], volume_;
    PhotonsByCellGpu by_cell_;
    gpu::ComputePipeline find_faces_, inject_, propagate_;
};

}  // namespace photond
