#include "renderer/methods/light_propagation_volumes/propagation_volumes_gpu.h"

#include <bit>

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
      most_(most),
      constants_(gpu::make_buffer(scene.device(), kVolumes, std::span(&cascades, 1))),
      faces_(words(scene.device(), uint64_t{cascades.count} * cascades.faces)),
      keys_(words(scene.device(), most)),
      values_(words(scene.device(), most)),
      injected_(lights(scene.device(), uint64_t{cascades.count} * cascades.cells)),
      steps_{lights(scene.device(), cascades.cells), lights(scene.device(), cascades.cells)},
      volume_(lights(scene.device(), uint64_t{cascades.count} * cascades.cells)),
      sort_(scene.device(), most),
      find_faces_(scene.device(), propagation_shader("volume_faces.comp"), sizeof(gpu::FacesPush), &scene.set(),
                  scene.specialization()),
      find_keys_(scene.device(), propagation_shader("volume_keys.comp"), sizeof(gpu::InjectionPush), &scene.set(),
                 scene.specialization()),
      inject_(scene.device(), propagation_shader("volume_inject.comp"), sizeof(gpu::InjectionPush)),
      propagate_(scene.device(), propagation_shader("volume_propagate.comp"), sizeof(gpu::PropagationPush)) {}

uint64_t PropagationVolumesGpu::device_bytes(const gpu::PropagationCascades& cascades, uint32_t most) {
    constexpr uint64_t kWordsAPhoton = 4;  // its key and cell, and the sort's own
    const uint64_t volumes = 2 * cascades.count + 2;
    return sizeof(cascades) + volumes * cascades.cells * sizeof(gpu::CellLight) +
           sizeof(uint32_t) * (uint64_t{cascades.count} * cascades.faces + kWordsAPhoton * most);
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
    const gpu::Scope scope(commands, "rsm");
    const gpu::InjectionPush push{cascade, most_};
    commands.bind(find_keys_, {gpu::read("cascades", constants_), gpu::read("state", photons.state()),
                               gpu::read("photons", photons.photons()), gpu::read("order", photons.order()),
                               gpu::write("keys", keys_), gpu::write("values", values_)});
    commands.push(push);
    commands.dispatch_threads(most_, PROPAGATION_GROUP);
    sort_.record(commands, keys_, values_, {photons.state(), REFLECTION_PHOTONS},
                 static_cast<uint32_t>(std::bit_width(host_cascades_.cells)));
    commands.bind(inject_, {gpu::read("cascades", constants_), gpu::read("state", photons.state()),
                            gpu::read("photons", photons.photons()), gpu::read("keys", keys_),
                            gpu::read("values", values_), gpu::write("injected", injected_)});
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
