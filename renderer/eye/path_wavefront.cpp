#include "renderer/eye/path_wavefront.h"

namespace photond {

uint64_t PathWavefront::bytes_per_thread() {
    return EyeBatch::bytes_for(kPaths) + ShadowBatch<WaitingLight>::bytes_for(kPaths) + kPaths * 8 * sizeof(float);
}

void PathWavefront::trace_tile(const PathScene& shared, const PassSampler& sampler, const Tile& tile, PassImage& image,
                               Counts& counts, EyeSeconds& seconds) {
    ThreadLaps laps;
    batch_.start(shared, sampler, tile, image);
    for (uint32_t vertex = 0; batch_.count > 0; ++vertex) {
        batch_.trace_rays(shared, vertex, counts);
        if (vertex == 0) laps.lap(seconds.camera);

        batch_.sort_hits(shared, image);
        draw_numbers(sampler, vertex);
        shade_lambert(shared, vertex, image);
        shade_general(shared, vertex, image);
        batch_.advance();
        add_unshadowed(shadows_, shared, vertex, image, counts);
        if (vertex == 0) laps.lap(seconds.direct);
    }
    laps.lap(seconds.indirect);  // once: asking the thread's clock is a system call
}

void PathWavefront::draw_numbers(const PassSampler& sampler, uint32_t vertex) {
    const std::span<const uint32_t> keys = batch_.keys_under_way();
    light_point_.draw(sampler, sample_set(vertex, VertexSet::LightPoint), keys);
    choice_.draw(sampler, sample_set(vertex, VertexSet::LightChoiceAndRoulette), keys);
    direction_.draw(sampler, sample_set(vertex, VertexSet::Direction), keys);
    if (!batch_.general.empty()) lobe_.draw(sampler, sample_set(vertex, VertexSet::Lobe), keys);
}

}  // namespace photond
