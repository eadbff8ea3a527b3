#include "renderer/methods/path_tracing/wavefront.h"

#include "renderer/eye/eye_contributions.h"
#include "renderer/transport/hit_prefetch.h"

namespace photond {

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
    return kPaths * (3 * sizeof(Ray) + sizeof(Hit) + 2 * sizeof(EyePath) + 4 * sizeof(uint32_t) + sizeof(Pending) +
                     sizeof(uint8_t) + 8 * sizeof(float));
}

void Wavefront::trace_tile(const PathTracingScene& shared, const PassSampler& sampler, const Tile& tile,
                           PassImage& image, Counts& counts, PathSeconds& seconds) {
    ThreadLaps laps;
    count_ = tile.pixels();
    start_eye_paths(shared, sampler, tile, {rays_.data(), count_}, {paths_.data(), count_}, {keys_.data(), count_});
    for (size_t i = 0; i < count_; ++i) clear_pixel(image, paths_[i].pixel);

    for (uint32_t vertex = 0; count_ > 0; ++vertex) {
        shared.intersector.closest_hits({rays_.data(), count_}, {hits_.data(), count_},
                                        vertex == 0 ? Coherence::Coherent : Coherence::Incoherent);
        (vertex == 0 ? counts.camera_rays : counts.bounce_rays) += count_;
        if (vertex == 0) laps.lap(seconds.camera);

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
        if (vertex == 0) laps.lap(seconds.direct);
    }
    laps.lap(seconds.indirect);  // once: asking the thread's clock is a system call
}

/// Ends the paths that met nothing, takes what solids on the way absorbed, and tells the others apart.
void Wavefront::sort_hits(const PathTracingScene& shared, PassImage& image) {
    lambert_.clear();
    general_.clear();
    for (uint32_t i = 0; i < count_; ++i) {
        const Hit& hit = hits_[i];
        EyePath& path = paths_[i];
        path.throughput *= shared.absorption.transmittance(path.media, hit.t);
        if (!hit.valid()) {
            add_environment(image, shared, path, rays_[i].direction);
            continue;
        }
        prefetch_index(shared.scene, hit);
        (shared.shading[hit.instance].lambert ? lambert_ : general_).push_back(i);
    }
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
