#include "renderer/eye/tiles.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace photond {

void start_eye_paths(const EyeScene& shared, const PassSampler& sampler, const Tile& tile, std::span<Ray> rays,
                     std::span<EyePath> paths, std::span<uint32_t> keys) {
    assert(rays.size() == tile.pixels() && paths.size() == tile.pixels() && keys.size() == tile.pixels());
    const uint32_t width = shared.view.film_size.width;
    size_t count = 0;
    for (uint32_t y = tile.y0; y < tile.y1; ++y) {
        for (uint32_t x = tile.x0; x < tile.x1; ++x) {
            EyePath& path = paths[count];
            path = EyePath{};
            path.pixel = y * width + x;
            keys[count++] = sampler.pixel_key(path.pixel);
        }
    }
    const bool lens = shared.view.camera.aperture_radius_m > 0;
    constexpr size_t kBlock = 256;
    std::array<float, kBlock> film_x, film_y, lens_x{}, lens_y{};
    for (size_t first = 0; first < count; first += kBlock) {
        const size_t block = std::min(kBlock, count - first);
        const std::span<const uint32_t> block_keys = keys.subspan(first, block);
        sampler.sample_2d(block_keys, sample_set(CameraSet::Film), {film_x.data(), block}, {film_y.data(), block});
        if (lens)
            sampler.sample_2d(block_keys, sample_set(CameraSet::Lens), {lens_x.data(), block}, {lens_y.data(), block});
        for (size_t i = 0; i < block; ++i) {
            const uint32_t pixel = paths[first + i].pixel;
            const vec2 corner(uvec2(pixel % width, pixel / width));
            rays[first + i] =
                shared.camera_rays(corner + shared.filter({film_x[i], film_y[i]}), vec2(lens_x[i], lens_y[i]));
        }
    }
}

void add_interleaved_stages(Stats& stats, double wall_seconds,
                            std::initializer_list<std::pair<std::string_view, double>> cpu_seconds) {
    double total = 1e-12;
    for (const auto& [name, seconds] : cpu_seconds) total += seconds;
    for (const auto& [name, seconds] : cpu_seconds) {
        Stage& stage = stats.stage(name);
        stage.cpu_seconds += seconds;
        stage.wall_seconds += wall_seconds * seconds / total;
    }
}

}  // namespace photond
