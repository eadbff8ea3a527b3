#include "renderer/eye/eye_batch.h"

#include <cassert>

#include "renderer/eye/eye_contributions.h"

namespace photond {

namespace {

/// Rays from the eye look the same way.
Coherence coherence_at(uint32_t vertex) { return vertex == 0 ? Coherence::Coherent : Coherence::Incoherent; }

}  // namespace

EyeBatch::EyeBatch(size_t most_paths) : PathBatch(most_paths) {
    lambert.reserve(most_paths);
    general.reserve(most_paths);
}

void EyeBatch::start(const EyeScene& shared, const PassSampler& sampler, const Tile& tile, PassImage& image) {
    count = tile.pixels();
    assert(count <= room() && "the tile is no larger than was said");
    start_eye_paths(shared, sampler, tile, {rays.data(), count}, {paths.data(), count}, {keys.data(), count});
    // A pass starts from black, tile by tile: by the thread that renders the tile.
    for (uint32_t y = tile.y0; y < tile.y1; ++y) image.clear(size_t{y} * image.size.width + tile.x0, tile.x1 - tile.x0);
}

void EyeBatch::trace_rays(const EyeScene& shared, uint32_t vertex, Counts& counts) {
    find_hits(shared.intersector, coherence_at(vertex));
    (vertex == 0 ? counts.camera_rays : counts.bounce_rays) += count;
}

void EyeBatch::sort_hits(const EyeScene& shared, PassImage& image) {
    lambert.clear();
    general.clear();
    for (uint32_t i = 0; i < count; ++i) {
        const Hit& hit = hits[i];
        EyePath& path = paths[i];
        path.throughput *= shared.absorption.transmittance(path.media, hit.t);
        if (!hit.valid()) {
            add_environment(image, shared, path, rays[i].direction);
            continue;
        }
        prefetch_index(shared.scene, hit);
        (shared.shading[hit.instance].lambert ? lambert : general).push_back(i);
    }
}

void add_unshadowed(ShadowBatch<WaitingLight>& shadows, const EyeScene& shared, uint32_t vertex, PassImage& image,
                    Counts& counts) {
    counts.shadow_rays += shadows.trace(shared.intersector, coherence_at(vertex), [&](const WaitingLight& light) {
        (light.indirect ? image.of<Layer::Indirect>() : image.of<Layer::Direct>())[light.pixel] += light.radiance;
    });
}

}  // namespace photond
