#pragma once
// Some thousand splats together: what they are, and which clusters of visible points each may light.
//
// Chunks of splats are made side by side; the pairs (cluster, splat) they find are then sorted by cluster, each
// cluster's in the order of its splats. So clusters can be lit side by side without locks, and their sums do not depend
// on threads.

#include <vector>

#include "renderer/core/cancel.h"
#include "renderer/core/stats.h"
#include "renderer/many_lights/vpl_set.h"
#include "renderer/methods/photon_splatting/beam_sizes.h"
#include "renderer/methods/photon_splatting/splat.h"
#include "renderer/methods/photon_splatting/splat_depth_maps.h"
#include "renderer/methods/photon_splatting/splat_settings.h"
#include "renderer/methods/photon_splatting/stratification.h"
#include "renderer/methods/photon_splatting/visible_clusters.h"

namespace photond {

/// What splats of all batches of a pass come from. Borrows everything.
struct SplatPass {
    const Scene& scene;
    const Intersector& intersector;
    const SplatSettings& settings;
    const BeamSizes& beam_sizes;
    const PhotonSplattingParams& params;
    const ShaftVisibility* shafts;  // null: shadow rays alone
    const TracedReflections& photons;
    std::span<const SplatSource> sources;  // empty: each photon for itself
    const VisibleClusters& clusters;
    uint64_t seed;
    uint32_t pass;

    size_t source_count() const { return sources.empty() ? photons.photons.size() : sources.size(); }
};

class SplatBatch {
public:
    /// Splats of a batch: where they lie over all of a large image they find some GiB of pairs if there are many more.
    static constexpr size_t kSplats = 1 << 12;
    /// Sources of a batch, for photons of so many rays.
    static size_t sources(uint32_t rays_per_photon) { return std::max<size_t>(kSplats / rays_per_photon, 1); }

    /// The splats of sources [first, last). Seconds of the finding go to `stats` as stage "splat_find", of depth maps
    /// as "splat_depth".
    void make(const SplatPass& pass, size_t first, size_t last, Stats& stats, const CancelToken& cancel);

    /// A splat that may light a cluster.
    struct Pair {
        uint32_t splat;  // in chunk `chunk`
        uint32_t chunk;
        uint32_t blockers;  // what may stand between: index into the chunk's, or one of these
    };
    static constexpr uint32_t kClear = ~0u, kUnknown = ~0u - 1;
    std::span<const Pair> of_cluster(uint32_t cluster) const {
        return std::span(pairs_).subspan(begins_[cluster], begins_[cluster + 1] - begins_[cluster]);
    }

    /// Splats that were made together.
    struct Chunk {
        struct Found {
            uint32_t cluster, splat, blockers;
        };
        std::vector<Splat> splats;
        std::vector<RoughOrigin> rough;
        std::vector<uint32_t> blockers;  // runs: how many triangles, and which
        std::vector<Found> found;
        SplatDepthMaps depth_maps{16};
        Counts counts;
        double seconds_finding = 0, seconds_depth = 0;
    };
    const Chunk& chunk(const Pair& pair) const { return chunks_[pair.chunk]; }
    /// What may stand between; of pairs that are neither clear nor unknown.
    std::span<const uint32_t> blockers(const Pair& pair) const {
        const std::vector<uint32_t>& all = chunks_[pair.chunk].blockers;
        return std::span(all).subspan(pair.blockers + 1, all[pair.blockers]);
    }

    uint64_t bytes() const;

private:
    void sort_pairs(size_t clusters);

    std::vector<Chunk> chunks_;
    size_t chunk_count_ = 0;
    std::vector<Pair> pairs_;
    std::vector<uint32_t> begins_, places_;
};

}  // namespace photond
