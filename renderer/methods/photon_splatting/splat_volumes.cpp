#include "renderer/methods/photon_splatting/splat_volumes.h"

#include <algorithm>

#include "renderer/methods/photon_splatting/splat_shared.h"

namespace photond {

namespace {

constexpr const char* kStructure = "splat_volumes";
constexpr VkFormat kLight = VK_FORMAT_R32G32B32A32_SFLOAT, kWeights = VK_FORMAT_R32G32_SFLOAT;
constexpr uint32_t kVertices = 36;  // of a box

std::string shader(const char* name) { return "renderer/methods/photon_splatting/" + std::string(name); }

}  // namespace

bool SplatVolumes::possible(const Needs& needs, const Camera& camera) {
    return needs.only_lambert() && !camera.orthographic && camera.aperture_radius_m == 0;
}

SplatVolumes::SplatVolumes(const gpu::DeviceScene& scene, Size2 size,
                           std::span<const gpu::Specialization> specialization)
    : device_(scene.device()),
      pixels_(static_cast<uint32_t>(size.pixels())),
      images_(device_, kStructure, {kLight, kWeights}, size),
      draw_(device_, shader("splat_volume.vert"), shader("splat_volume.frag"), sizeof(gpu::SplatClusterPush),
            images_.options(), &scene.set(), specialization),
      sum_(device_, shader("splat_volume.comp"), sizeof(uint32_t)) {}

uint32_t SplatVolumes::splats_at_once() const {
    // A beam covers a tenth of the image, at a guess, and a fragment is next to nothing beside a path.
    constexpr uint64_t kFragmentsOfPath = 32;
    return static_cast<uint32_t>(
        std::clamp<uint64_t>(10 * kFragmentsOfPath * device_.paths_per_submit() / pixels_, 64, 1u << 20));
}

void SplatVolumes::record(gpu::CommandList& commands, const Points& points, gpu::Buffer& splats,
                          gpu::Buffer& depth_maps, uint32_t first, uint32_t end, bool clear) {
    gpu::RasterPass pass(commands, draw_, images_.targets(clear),
                         {gpu::read("eye", points.eye), gpu::read("splats", splats),
                          gpu::read("constants", points.constants), gpu::read("first_of_pixel", points.heads),
                          gpu::read("points", points.points), gpu::read("farthest_m", depth_maps)});
    pass.push(gpu::SplatClusterPush{0, 0, first, end});
    pass.draw(kVertices, end - first);
}

void SplatVolumes::record_sums(gpu::CommandList& commands, const Points& points) {
    images_.record_copies(commands);
    commands.bind(sum_, {gpu::read_write("device_counters", points.counters), gpu::read("first_of_pixel", points.heads),
                         gpu::read("light_and_splats", images_.copy(0)),
                         gpu::read("weight_and_contributions", images_.copy(1)), gpu::read_write("sums", points.sums)});
    commands.push(pixels_);
    commands.dispatch_threads(pixels_, SPLAT_GROUP);
}

}  // namespace photond
