#include "renderer/methods/image_space_photon_mapping/photon_raster.h"

#include <algorithm>

#include "renderer/methods/image_space_photon_mapping/photon_scatter_shared.h"

namespace photond {

namespace {

constexpr VkFormat kLightAndPhotons = VK_FORMAT_R32G32B32A32_SFLOAT;

std::string raster_shader(const char* name) {
    return "renderer/methods/image_space_photon_mapping/" + std::string(name);
}

Size2 drawn_size(const SplitLayout& layout) { return {layout.tile_width, layout.tile_height}; }

uint32_t vertices_of(PhotonFootprint footprint) {
    switch (footprint) {
        case PhotonFootprint::Quad: return 6;
        case PhotonFootprint::Volume: return 60;
        case PhotonFootprint::Auto: return 36;
    }
    return 0;
}

}  // namespace

PhotonRaster::PhotonRaster(const gpu::DeviceScene& scene, const SplitLayout& layout, PhotonFootprint footprint,
                           std::span<const gpu::Specialization> specialization)
    : device_(scene.device()),
      pixels_(static_cast<uint32_t>(drawn_size(layout).pixels())),
      vertices_(vertices_of(footprint)),
      image_(device_, "drawn_photons", {kLightAndPhotons}, drawn_size(layout)),
      draw_(device_, raster_shader("photon_raster.vert"), raster_shader("photon_raster.frag"),
            sizeof(gpu::PhotonRasterPush), image_.options(), &scene.set(), specialization),
      sum_(device_, raster_shader("photon_raster.comp"), sizeof(gpu::PhotonRasterPush), &scene.set(), specialization) {}

uint64_t PhotonRaster::device_bytes(const SplitLayout& layout) {
    return AddedImages::device_bytes(std::array{kLightAndPhotons}, drawn_size(layout));
}

uint32_t PhotonRaster::photons_at_once(double pixels) const {
    constexpr double kFragmentsOfPath = 32;
    return static_cast<uint32_t>(
        std::clamp(kFragmentsOfPath * device_.paths_per_submit() / std::max(pixels, 1.0), 64.0, 1048576.0));
}

void PhotonRaster::record(gpu::CommandList& commands, const Pass& pass, uint32_t map, uint32_t first, uint32_t end,
                          bool clear) {
    gpu::RasterPass raster(commands, draw_, image_.targets(clear),
                           {gpu::read("constants", pass.constants), gpu::read("points", pass.points),
                            gpu::read("grid_starts", pass.starts), gpu::read("grid_places", pass.places),
                            gpu::read("map_powers", pass.powers)});
    raster.push(gpu::PhotonRasterPush{map, first});
    raster.draw(vertices_, end - first);
}

void PhotonRaster::record_sums(gpu::CommandList& commands, const Pass& pass, uint32_t map) {
    image_.record_copies(commands);
    commands.bind(sum_, {gpu::read("constants", pass.constants), gpu::read("points", pass.points),
                         gpu::read("grid_starts", pass.starts), gpu::read("light_and_photons", image_.copy(0)),
                         gpu::read_write("sums", pass.sums), gpu::read_write("device_layers", pass.layers)});
    commands.push(gpu::PhotonRasterPush{map, 0});
    commands.dispatch_threads(pixels_, SCATTER_GROUP);
}

}  // namespace photond
