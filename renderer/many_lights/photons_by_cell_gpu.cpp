#include "renderer/many_lights/photons_by_cell_gpu.h"

#include <bit>

namespace photond {

PhotonsByCellGpu::PhotonsByCellGpu(const gpu::DeviceScene& scene, uint32_t most, uint32_t cells,
                                   const std::string& find_cells, uint32_t push_bytes)
    : most_(most),
      cells_(cells),
      keys_(scene.device(), "photons_by_cell", uint64_t{most} * sizeof(uint32_t)),
      values_(scene.device(), "photons_by_cell", uint64_t{most} * sizeof(uint32_t)),
      sort_(scene.device(), most),
      find_cells_(scene.device(), find_cells, push_bytes, &scene.set(), scene.specialization()) {}

uint64_t PhotonsByCellGpu::device_bytes(uint32_t most) {
    constexpr uint64_t kWordsAPhoton = 4;  // its cell and itself, and the sort's own
    return kWordsAPhoton * most * sizeof(uint32_t);
}

void PhotonsByCellGpu::append_to(std::vector<gpu::Binding>& bindings, VplTracerGpu& photons) {
    bindings.insert(bindings.end(), {gpu::read("state", photons.state()), gpu::read("photons", photons.photons()),
                                     gpu::read("keys", keys_), gpu::read("values", values_)});
}

void PhotonsByCellGpu::bind(gpu::CommandList& commands, VplTracerGpu& photons, std::vector<gpu::Binding> bindings) {
    bindings.insert(bindings.end(),
                    {gpu::read("state", photons.state()), gpu::read("photons", photons.photons()),
                     gpu::read("order", photons.order()), gpu::write("keys", keys_), gpu::write("values", values_)});
    commands.bind(find_cells_, bindings);
}

void PhotonsByCellGpu::record_sort(gpu::CommandList& commands, VplTracerGpu& photons) {
    commands.dispatch_threads(most_, REFLECTION_GROUP);
    sort_.record(commands, keys_, values_, {photons.state(), REFLECTION_PHOTONS},
                 static_cast<uint32_t>(std::bit_width(cells_)));
}

}  // namespace photond
