#include "renderer/many_lights/vpl_set_gpu.h"

#include <algorithm>

#include "renderer/scene/scene.h"

namespace photond {

VplSetGpu::VplSetGpu(const gpu::DeviceScene& scene, uint32_t most, float connect_threshold, uint32_t likely)
    : most_(most),
      likely_(std::min(most, likely)),
      connect_threshold_(connect_threshold),
      vpls_(scene.device(), "vpls", uint64_t{most} * sizeof(gpu::Vpl)),
      lobes_(scene.device(), "vpls", (scene.scene().needs.only_lambert() ? 1 : uint64_t{most}) * sizeof(gpu::VplLobes)),
      counts_(scene.device(), "vpls", VPL_COUNT_WORDS * sizeof(uint32_t)),
      host_counts_(scene.device(), "readback", counts_.bytes(), gpu::MemoryKind::Readback),
      gather_(scene.device(), "renderer/many_lights/vpl_gather.comp", sizeof(gpu::VplGatherPush), &scene.set(),
              scene.specialization()) {}

uint64_t VplSetGpu::device_bytes(uint32_t most, bool lambert) {
    return uint64_t{most} * sizeof(gpu::Vpl) + (lambert ? 1 : uint64_t{most}) * sizeof(gpu::VplLobes) +
           VPL_COUNT_WORDS * sizeof(uint32_t);
}

void VplSetGpu::record(gpu::CommandList& commands, const Photons& photons) {
    const gpu::Scope scope(commands, "vpl_generation");
    commands.bind(gather_, {gpu::read("state", photons.state), gpu::read("photons", photons.photons),
                            gpu::read("order", photons.order), gpu::read("surfaces", photons.surfaces),
                            gpu::write("vpls", vpls_), gpu::write("lobes", lobes_), gpu::write("counts", counts_)});
    commands.push(gpu::VplGatherPush{most_, connect_threshold_});
    commands.dispatch_threads(most_, VPL_SET_GROUP);
    commands.copy(counts_, 0, host_counts_, 0, counts_.bytes());
    commands.host_reads(host_counts_);
}

}  // namespace photond
