#include "renderer/methods/light_propagation_volumes/propagation_volumes_gpu.h"

namespace photond {

namespace {

constexpr const char* kVolumes = "propagation_volumes";

std::string propagation_shader(const char* name) {
    return "renderer/methods/light_propagation_volumes/" + std::string(name);
}
gpu::Buffer lights(gpu::Device& device, uint64_t cells) { return {device, kVolumes, cells * sizeof(gpu::CellLight)}; }
gpu::Buffer words(gpu::Device& device, uint64_t count) { return {device, kVolumes, count * sizeof(uint32_t)}; }

}  // namespace

PropagationVolumesGpu::PropagationVolumesGpu(const gpu::DeviceScene& scene, const gpu::PropagationCascades& cascades,
                                             uint32_t most)
    : scene_(scene),
      host_cascades_(cascades),
      constants_(gpu::make_buffer(scene.device(), kVolumes, std::span(&cascades, 1))),
      faces_(words(scene.device(), uint64_t{cascades.count} * cascades.faces)),
      injected_(lights(scene.device(), uint64_t{cascades.count} * cascades.cells)),
      steps_{lights(scene.device(), cascades.cells), lights(scene.device(), cascades.cells)},
      volume_(lights(scene.device(), uint64_t{cascades.count} * cascades.cells)),
      by_cell_(scene, most, cascades.cells, propagation_shader("volume_keys.comp"), sizeof(gpu::InjectionPush)),
      find_faces_(scene.device(), propagation_shader("volume_faces.comp"), sizeof(gpu::FacesPush), &scene.set(),
                  scene.specialization()),
      inject_(scene.device(), propagation_shader("volume_inject.comp"), sizeof(gpu::InjectionPush)),
      propagate_(scene.device(), propagation_shader("volume_propagate.comp"), sizeof(gpu::PropagationPush)) {}

uint64_t PropagationVolumesGpu::device_bytes(const gpu::PropagationCascades& cascades, uint32_t most) {
    const uint64_t volumes = 2 * cascades.count + 2;
    return sizeof(cascades) + volumes * cascades.cells * sizeof(gpu::CellLight) +
           sizeof(uint32_t) * uint64_t{cascades.count} * cascades.faces + PhotonsByCellGpu::device_bytes(most);
}

void PropagationVolumesGpu::find_faces(bool asked, Stats& stats) {
    gpu::Device& device = scene_.device();
    const uint32_t all = host_cascades_.count * host_cascades_.faces;
    constexpr uint32_t kRaysAPath = 8;
    const auto at_once = static_cast<uint32_t>(kRaysAPath * device.paths_per_submit() / (6 * FACE_POINTS)) + 1;
    for (uint32_t first = 0; first < all; first += asked ? at_once : all) {
        gpu::CommandList commands(device);
        if (asked) {
            const gpu::Scope scope(commands, "voxelise");
            const uint32_t end = std::min(first + at_once, all);
            commands.bind(find_faces_, {gpu::read("cascades", constants_), gpu::write("open_faces", faces_)});
            commands.push(gpu::FacesPush{first, end});
            commands.dispatch_threads(end - first, PROPAGATION_GROUP);
        } else {
            commands.fill(faces_, FACE_OPEN | FACE_OPEN << FACE_BITS | FACE_OPEN << 2 * FACE_BITS);
        }
        commands.submit();
        commands.wait();
        commands.add_times(stats);
    }
}

void PropagationVolumesGpu::record_injection(gpu::CommandList& commands, VplTracerGpu& photons, uint32_t cascade) {
    const gpu::Scope scope(commands, "inject");
    const gpu::InjectionPush push{cascade};
    by_cell_.record(commands, photons, {gpu::read("cascades", constants_)}, push);
    std::vector<gpu::Binding> bindings = {gpu::read("cascades", constants_), gpu::write("injected", injected_)};
    by_cell_.append_to(bindings, photons);
    commands.bind(inject_, bindings);
    commands.push(push);
    commands.dispatch_threads(host_cascades_.cells, PROPAGATION_GROUP);
}

void PropagationVolumesGpu::record_steps(gpu::CommandList& commands, uint32_t cascade, uint32_t first, uint32_t end) {
    const gpu::Scope scope(commands, "propagate");
    for (uint32_t step = first; step < end; ++step) {
        commands.bind(propagate_,
                      {gpu::read("cascades", constants_), gpu::read("open_faces", faces_),
                       gpu::read("injected", injected_), gpu::read("step_before", steps_[step % 2]),
                       gpu::write("step_after", steps_[(step + 1) % 2]), gpu::read_write("volume", volume_)});
        commands.push(gpu::PropagationPush{cascade, step == 0 ? 1u : 0u});
        commands.dispatch_threads(host_cascades_.cells, PROPAGATION_GROUP);
    }
}

}  // namespace photond
