#include "renderer/gbuffer/gbuffer_gpu.h"

#include <algorithm>

#include "renderer/eye/eye_constants.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

namespace {

const char* walk_shader(const GBufferShadows& shadows) {
    if (shadows.depth_maps) return "renderer/gbuffer/gbuffer_walk_depth_maps.comp";
    if (shadows.centres) return "renderer/gbuffer/gbuffer_walk_centre_shadows.comp";
    return "renderer/gbuffer/gbuffer_walk.comp";
}

}  // namespace

GBufferGpu::GBufferGpu(const gpu::DeviceScene& scene, const View& view, uint64_t seed, const GBufferWalk& walk,
                       DeviceImage& image, const GBufferShadows& shadows)
    : device_(scene.device()),
      image_(image),
      shadows_(shadows),
      walk_(walk),
      layout_(view.film_size, walk.split_side),
      seed_(seed),
      tiles_(eye_tile_count(view.film_size)),
      tiles_a_piece_(std::max(device_.paths_per_submit() / kEyeTilePixels, 1u)),
      pieces_((tiles_ + tiles_a_piece_ - 1) / tiles_a_piece_),
      eye_(device_, "eye", sizeof(gpu::EyeConstants)),
      sampler_(device_, "sampler", sizeof(gpu::PassSamplerData)),
      points_(device_, "g_buffer", uint64_t{layout_.points()} * sizeof(gpu::GBufferPoint)),
      general_(device_, "g_buffer",
               (scene.scene().needs.only_lambert() ? 1 : uint64_t{layout_.points()}) * sizeof(gpu::GBufferGeneral)),
      sums_(device_, "g_buffer", uint64_t{layout_.points()} * sizeof(vec3)),
      pipeline_(device_, walk_shader(shadows), sizeof(gpu::GBufferWalkPush), &scene.set(), scene.specialization()) {
    const gpu::EyeConstants eye = make_eye_constants(view, walk.max_scatterings, ROULETTE_START);
    gpu::upload(device_, eye_, std::as_bytes(std::span(&eye, 1)));
    // Padding holds no points: the walk never comes there.
    gpu::CommandList commands(device_);
    commands.fill(points_, 0);
    commands.submit();
    commands.wait();
}

uint64_t GBufferGpu::device_bytes(Size2 size, uint32_t split_side, const Needs& needs) {
    const uint64_t points = SplitLayout(size, split_side).points();
    return points * (sizeof(gpu::GBufferPoint) + sizeof(vec3)) +
           (needs.only_lambert() ? 1 : points) * sizeof(gpu::GBufferGeneral) + sizeof(gpu::EyeConstants) +
           sizeof(gpu::PassSamplerData);
}

void GBufferGpu::record(gpu::CommandList& commands, uint32_t pass, uint32_t piece) {
    if (piece == 0) {
        commands.update(sampler_, PassSampler(walk_.sampler, seed_, RandomDomain::Camera, pass).device_data());
        commands.fill(sums_, 0);
        if (shadows_.centres) commands.fill(shadows_.centres->lights(), NO_LAMP);
    }
    const uint32_t first = piece * tiles_a_piece_, end = std::min(first + tiles_a_piece_, tiles_);
    const gpu::Scope scope(commands, "direct");
    std::vector<gpu::Binding> bindings = {gpu::read_write("device_layers", image_.layers()),
                                          gpu::read_write("device_counters", image_.counters()),
                                          gpu::read("eye", eye_),
                                          gpu::read("pass_sampler", sampler_),
                                          gpu::write("points", points_),
                                          gpu::write("general_points", general_)};
    if (LightDepthMapsGpu* const maps = shadows_.depth_maps)
        bindings.insert(bindings.end(),
                        {gpu::read("light_depth_constants", maps->constants()),
                         gpu::read("light_depth_maps", maps->maps()), gpu::read("light_depths_m", maps->depths())});
    if (CentreShadowsGpu* const centres = shadows_.centres)
        bindings.insert(bindings.end(),
                        {gpu::read("lamp_shapes", centres->shapes()), gpu::read("lamp_words", centres->words()),
                         gpu::write("unshadowed_lights", centres->lights())});
    commands.bind(pipeline_, bindings);
    commands.push(gpu::GBufferWalkPush{split(), first, end, walk_.glossy_threshold});
    commands.dispatch_threads(uint64_t{end - first} * kEyeTilePixels, kEyeTilePixels);
}

}  // namespace photond
