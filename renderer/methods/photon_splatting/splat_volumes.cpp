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
      light_(device_, kStructure, kLight, size.width, size.height),
      weights_(device_, kStructure, kWeights, size.width, size.height),
      light_copy_(device_, kStructure, light_.packed_bytes()),
      weights_copy_(device_, kStructure, weights_.packed_bytes()),
      draw_(device_, shader("splat_volume.vert"), shader("splat_volume.frag"), sizeof(gpu::SplatClusterPush),
            {.colors = {{kLight, gpu::Blend::Add}, {kWeights, gpu::Blend::Add}}}, &scene.set(), specialization),
      sum_(device_, shader("splat_volume.comp"), sizeof(uint32_t)) {}

uint32_t SplatVolumes::splats_at_once() const {
    // A beam covers a tenth of the image, at a guess, and a fragment is next to nothing beside a path.
    constexpr uint64_t kFragmentsOfPath = 32;
    return static_cast<uint32_t>(
        std::clamp<uint64_t>(10 * kFragmentsOfPath * device_.paths_per_submit() / pixels_, 64, 1u << 20));
}

void SplatVolumes::record(gpu::CommandList& commands, const Points& points, gpu::Buffer& splats,
                          gpu::Buffer& depth_maps, uint32_t first, uint32_t end, bool clear) {
    constexpr std::array<float, 4> kBlack{};
    const gpu::RasterTargets cleared{{gpu::clear(light_, kBlack), gpu::clear(weights_, kBlack)}, {}};
    const gpu::RasterTargets kept{{gpu::load(light_), gpu::load(weights_)}, {}};
    gpu::RasterPass pass(commands, draw_, clear ? cleared : kept,
                         {gpu::read("eye", points.eye), gpu::read("splats", splats),
                          gpu::read("constants", points.constants), gpu::read("first_of_pixel", points.heads),
                          gpu::read("points", points.points), gpu::read("farthest_m", depth_maps)});
    pass.push(gpu::SplatClusterPush{0, 0, first, end});
    pass.draw(kVertices, end - first);
}

void SplatVolumes::record_sums(gpu::CommandList& commands, const Points& points) {
    gpu::copy(commands, light_, light_copy_);
    gpu::copy(commands, weights_, weights_copy_);
    commands.bind(sum_, {gpu::read_write("device_counters", points.counters), gpu::read("first_of_pixel", points.heads),
                         gpu::read("light_and_splats", light_copy_),
                         gpu::read("weight_and_contributions", weights_copy_), gpu::read_write("sums", points.sums)});
    commands.push(pixels_);
    commands.dispatch_threads(pixels_, SPLAT_GROUP);
}

}  // namespace photond
