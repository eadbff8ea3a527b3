#pragma once
// A tile's paths from the eye, traced together: how they begin, what they find where they meet nothing, and which of
// their hits are shaded in lanes. Path tracing and the specular walk go on from there, each in its own way.

#include "renderer/eye/eye_path.h"
#include "renderer/eye/eye_scene.h"
#include "renderer/eye/tiles.h"
#include "renderer/transport/hit_prefetch.h"
#include "renderer/transport/path_batch.h"

namespace photond {

/// Numbers of two dimensions, one a path.
struct PathNumbers {
    std::vector<float> x, y;

    explicit PathNumbers(size_t paths = 0) : x(paths), y(paths) {}
    void draw(const PassSampler& sampler, uint32_t set, std::span<const uint32_t> keys) {
        sampler.sample_2d(keys, set, {x.data(), keys.size()}, {y.data(), keys.size()});
    }
};

/// Scratch of one thread.
class EyeBatch : public PathBatch<EyePath> {
public:
    explicit EyeBatch(size_t most_paths);
    static constexpr uint64_t bytes_for(size_t most_paths) {
        return PathBatch::bytes_for(most_paths) + most_paths * 2 * sizeof(uint32_t);
    }

    /// The tile's paths, at most as many as there is room for. Their pixels of `image` are cleared.
    void start(const EyeScene& shared, const PassSampler& sampler, const Tile& tile, PassImage& image);
    /// Where the rays under way end; they go to `counts`.
    void trace_rays(const EyeScene& shared, uint32_t vertex, Counts& counts);
    /// Ends the paths that met nothing, takes what solids on the way absorbed, and tells the others apart.
    void sort_hits(const EyeScene& shared, PassImage& image);
    /// Brings the Lambert hits from place `first` on into the lanes and calls draw(lane, path) for each; lanes past the
    /// end repeat the last path and are not to be read. Returns how many are.
    template <class Draw>
    size_t gather_lambert(const EyeScene& shared, size_t first, LambertGroup& group, const Draw& draw) const {
        for (size_t lane = 0; lane < kLanes; ++lane) {
            const size_t place = std::min(first + lane, lambert.size() - 1);
            prefetch_ahead(shared.scene, hits, lambert, place);
            const uint32_t i = lambert[place];
            group.gather(lane, shared.scene, shared.shading[hits[i].instance].varies, hits[i], rays[i],
                         paths[i].throughput, paths[i].eta_scale);
            draw(lane, i);
        }
        return std::min(kLanes, lambert.size() - first);
    }
    std::span<const uint32_t> keys_under_way() const { return {keys.data(), count}; }

    std::vector<uint32_t> lambert, general;  // paths by how their hits are shaded
};

/// A light sample at a vertex of such a path.
struct WaitingLight {
    Rgb radiance;
    uint32_t pixel;
    bool indirect;
};

/// Adds the light that shadow rays from vertices of that number find unshadowed.
void add_unshadowed(ShadowBatch<WaitingLight>& shadows, const EyeScene& shared, uint32_t vertex, PassImage& image,
                    Counts& counts);

}  // namespace photond
