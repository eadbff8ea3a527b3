#include "renderer/methods/path_tracing/wavefront.h"

#include "renderer/methods/path_tracing/contributions.h"
#include "renderer/scene/surface_color.h"

#include <ctime>

namespace photond {

namespace {

double thread_seconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

void clear_pixel(PassImage& image, uint32_t pixel) {
    for (std::vector<Rgb>* layer : {&image.emitted, &image.direct, &image.indirect, &image.caustic, &image.albedo,
                                    &image.normal, &image.position})
        if (!layer->empty()) (*layer)[pixel] = Rgb(0);
    if (!image.depth.empty()) image.depth[pixel] = 0;
    if (!image.hit.empty()) image.hit[pixel] = 0;
}

void prefetch_index(const Scene& scene, const Hit& hit) {
    if (hit.valid()) __builtin_prefetch(&scene.meshes[scene.instances[hit.instance].mesh].triangles[hit.triangle]);
}

void prefetch_corners(const Scene& scene, const Hit& hit) {
    const Mesh& mesh = scene.meshes[scene.instances[hit.instance].mesh];
    const uvec3 corner = mesh.triangles[hit.triangle];
    for (int i = 0; i < 3; ++i) {
        __builtin_prefetch(&mesh.positions[corner[i]]);
        if (!mesh.normals.empty()) __builtin_prefetch(&mesh.normals[corner[i]]);
        if (!mesh.uv[0].empty()) __builtin_prefetch(&mesh.uv[0][corner[i]]);
    }
}

}  // namespace

Wavefront::Wavefront()
    : rays_(kPaths),
      next_rays_(kPaths),
      paths_(kPaths),
      next_paths_(kPaths),
      keys_(kPaths),
      next_keys_(kPaths),
      hits_(kPaths),
      shadow_rays_(kPaths),
      pending_(kPaths),
      occluded_(kPaths) {
    lambert_.reserve(kPaths);
    general_.reserve(kPaths);
    for (Numbers* numbers : {&light_point_, &choice_, &direction_, &lobe_})
        numbers->x.resize(kPaths), numbers->y.resize(kPaths);
}

uint64_t Wavefront::bytes_per_thread() {
    return kPaths * (3 * sizeof(Ray) + sizeof(Hit) + 2 * sizeof(Path) + 4 * sizeof(uint32_t) + sizeof(Pending) +
                     sizeof(uint8_t) + 8 * sizeof(float));
}

void Wavefront::trace_tile(const PathTracingScene& shared, const PassSampler& sampler, const Tile& tile,
                           PassImage& image, Counts& counts, PathSeconds& seconds) {
    double then = thread_seconds();
    const auto lap = [&then](double& part) {
        const double now = thread_seconds();
        part += now - then;
        then = now;
    };
    start_paths(shared, sampler, tile);
    for (size_t i = 0; i < count_; ++i) clear_pixel(image, paths_[i].pixel);

    for (uint32_t vertex = 0; count_ > 0; ++vertex) {
        shared.intersector.closest_hits({rays_.data(), count_}, {hits_.data(), count_},
                                        vertex == 0 ? Coherence::Coherent : Coherence::Incoherent);
        (vertex == 0 ? counts.camera_rays : counts.bounce_rays) += count_;
        if (vertex == 0) lap(seconds.camera);

        sort_hits(shared, image);
        draw_numbers(sampler, vertex);
        next_count_ = 0;
        shadow_count_ = 0;
        shade_lambert(shared, vertex, image);
        shade_general(shared, vertex, image);
        next_paths_.swap(paths_);
        next_rays_.swap(rays_);
        next_keys_.swap(keys_);
        count_ = next_count_;
        trace_shadow_rays(shared, vertex, image, counts);
        if (vertex == 0) lap(seconds.direct);
    }
    lap(seconds.indirect);  // once: asking the thread's clock is a system call
}

void Wavefront::start_paths(const PathTracingScene& shared, const PassSampler& sampler, const Tile& tile) {
    count_ = 0;
    for (uint32_t y = tile.y0; y < tile.y1; ++y) {
        for (uint32_t x = tile.x0; x < tile.x1; ++x) {
            Path& path = paths_[count_];
            path = Path{};
            path.pixel = y * shared.view.film_size.width + x;
            keys_[count_++] = sampler.pixel_key(path.pixel);
        }
    }
    const std::span<const uint32_t> keys(keys_.data(), count_);
    sampler.sample_2d(keys, sample_set(CameraSet::Film), {direction_.x.data(), count_}, {direction_.y.data(), count_});
    const bool lens = shared.view.camera.aperture_radius_m > 0;
    if (lens) sampler.sample_2d(keys, sample_set(CameraSet::Lens), {lobe_.x.data(), count_}, {lobe_.y.data(), count_});
    for (size_t i = 0; i < count_; ++i) {
        const uint32_t pixel = paths_[i].pixel, width = shared.view.film_size.width;
        const uvec2 place(pixel % width, pixel / width);
        const vec2 corner(place);
        rays_[i] = shared.camera_rays(corner + shared.filter({direction_.x[i], direction_.y[i]}),
                                      lens ? vec2(lobe_.x[i], lobe_.y[i]) : vec2(0));
    }
}

/// Ends the paths that met nothing, takes what solids on the way absorbed, and tells the others apart.
void Wavefront::sort_hits(const PathTracingScene& shared, PassImage& image) {
    // A hit's triangle is seldom in the cache, but all hits are known: indices are asked for now, corners some paths
    // ahead of their use.
    lambert_.clear();
    general_.clear();
    for (uint32_t i = 0; i < count_; ++i) {
        const Hit& hit = hits_[i];
        Path& path = paths_[i];
        path.throughput *= shared.absorption.transmittance(path.media, hit.t);
        if (!hit.valid()) {
            add_environment(image, shared, path, rays_[i].direction);
            continue;
        }
        prefetch_index(shared.scene, hit);
        (shared.shading[hit.instance].lambert ? lambert_ : general_).push_back(i);
    }
}

void Wavefront::prefetch_ahead(const Scene& scene, std::span<const uint32_t> order, size_t position) const {
    constexpr size_t kCorners = 24, kTexels = 12;  // paths ahead: a texel's place is known by the corners
    const auto corners = [&](size_t k) {
        if (k < order.size()) prefetch_corners(scene, hits_[order[k]]);
    };
    const auto texels = [&](size_t k) {
        if (k >= order.size() || !scene.needs.base_color_textures) return;
        const Hit& hit = hits_[order[k]];
        prefetch_base_color(scene, scene.meshes[scene.instances[hit.instance].mesh], hit.triangle, hit.u, hit.v);
    };
    if (position == 0) {
        for (size_t k = 0; k < kCorners; ++k) corners(k);
        for (size_t k = 0; k < kTexels; ++k) texels(k);
    }
    corners(position + kCorners);
    texels(position + kTexels);
}

void Wavefront::draw_numbers(const PassSampler& sampler, uint32_t vertex) {
    const std::span<const uint32_t> keys(keys_.data(), count_);
    const auto draw = [&](VertexSet set, Numbers& numbers) {
        sampler.sample_2d(keys, sample_set(vertex, set), {numbers.x.data(), count_}, {numbers.y.data(), count_});
    };
    draw(VertexSet::LightPoint, light_point_);
    draw(VertexSet::LightChoiceAndRoulette, choice_);
    draw(VertexSet::Direction, direction_);
    if (!general_.empty()) draw(VertexSet::Lobe, lobe_);
}

void Wavefront::trace_shadow_rays(const PathTracingScene& shared, uint32_t vertex, PassImage& image, Counts& counts) {
    shared.intersector.occluded({shadow_rays_.data(), shadow_count_}, {occluded_.data(), shadow_count_},
                                vertex == 0 ? Coherence::Coherent : Coherence::Incoherent);
    counts.shadow_rays += shadow_count_;
    for (size_t i = 0; i < shadow_count_; ++i) {
        if (occluded_[i]) continue;
        const Pending& light = pending_[i];
        (light.indirect ? image.indirect : image.direct)[light.pixel] += light.radiance;
    }
}

}  // namespace photond
