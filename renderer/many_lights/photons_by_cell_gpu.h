#pragma once
// A pass's photons sorted by the cells of some grid or tree that they light, so that each cell sums its own in one
// order.

#include "renderer/backends/gpu/radix_sort.h"
#include "renderer/many_lights/vpl_tracer_gpu.h"

namespace photond {

class PhotonsByCellGpu {
public:
    /// `find_cells`: a shader, a thread a photon in the pass's order, that reads `state`, `photons` and `order` and
    /// writes for each its cell (`keys`; `cells`: none) and itself (`values`). It is pushed `push_bytes`.
    PhotonsByCellGpu(const gpu::DeviceScene& scene, uint32_t most, uint32_t cells, const std::string& find_cells,
                     uint32_t push_bytes);
    static uint64_t device_bytes(uint32_t most);

    /// Finds the cells and sorts. `bindings`: of `find_cells` beside those named above.
    void record(gpu::CommandList& commands, VplTracerGpu& photons, std::vector<gpu::Binding> bindings) {
        bind(commands, photons, std::move(bindings));
        record_sort(commands, photons);
    }
    template <class Push>
    void record(gpu::CommandList& commands, VplTracerGpu& photons, std::vector<gpu::Binding> bindings,
                const Push& push) {
        bind(commands, photons, std::move(bindings));
        commands.push(push);
        record_sort(commands, photons);
    }
    /// What photons_by_cell.glsl asks for.
    void append_to(std::vector<gpu::Binding>& bindings, VplTracerGpu& photons);

private:
    void bind(gpu::CommandList& commands, VplTracerGpu& photons, std::vector<gpu::Binding> bindings);
    void record_sort(gpu::CommandList& commands, VplTracerGpu& photons);

    const uint32_t most_, cells_;
    gpu::Buffer keys_, values_;
    gpu::RadixSort sort_;
    gpu::ComputePipeline find_cells_;
};

}  // namespace photond
