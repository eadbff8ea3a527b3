#pragma once
// The light's sub-paths of a pass: their vertices, which eye vertices are joined with, and what the camera sees of
// them.

#include <memory>
#include <vector>

#include "renderer/bidirectional/bidirectional_scene.h"
#include "renderer/bidirectional/merging_correlation.h"
#include "renderer/bidirectional/technique_choice.h"
#include "renderer/core/cancel.h"
#include "renderer/core/stats.h"
#include "renderer/photons/hash_grid.h"
#include "renderer/transport/vertex_scattering.h"

namespace photond {

/// A vertex of a light path, on a surface with a lobe that is no delta.
struct LightVertex {
    vec3 position;           // ShadingPoint::position [m]
    vec3 normal;             // unit, geometric, on the side the path came from
    vec3 from;               // unit, back to where the path came from
    Rgb power_w;             // that arrived, over the number of light paths
    SubpathWeights weights;  // as after arrive()
    uint32_t instance;       // with triangle, u and v: the hit
    uint32_t triangle;
    float u, v;
    float outside_ior;  // as make_bsdf() wants it
    float acceptance;   // MergeDisc::acceptance_m2()
    uint32_t path;      // of the pass
    uint32_t place;     // of LightPaths::places, where those are kept
    uint32_t surfaces;  // met so far, this one included
    bool all_delta;     // the scatterings before this vertex

    bool first_surface() const { return surfaces == 1; }
    bool caustic() const { return surfaces > 1 && all_delta; }
    /// As the path met it.
    SurfaceVertex surface(const Scene& scene) const;
};

/// What the camera sees of a light path; of a pilot without its weight.
struct LightSplat {
    vec2 film;     // pixels
    Rgb radiance;  // of a pixel whose filter is 1 there
    uint32_t scatterings;
    bool caustic;
    uint32_t block;  // of the pixels that it is weighed for; TechniqueBlocks::kOfAll: of all
};

/// Of one pass.
struct LightPaths {
    std::vector<LightVertex> vertices;  // run by run of the numbers, whatever the number of threads
    // Where merging is weighed by merging_correlation.h: the surfaces of all paths, delta ones among them, each path's
    // in a row.
    std::vector<PathVertex> places;
    std::vector<LightSplat> splats;
    std::vector<CandidateWeight> splat_weights;  // of a pilot: of each splat by each candidate
    // Where paths are asked for: path i has by_path[first_of_path[i]] and on, until first_of_path[i + 1].
    std::vector<uint32_t> first_of_path;
    std::vector<uint32_t> by_path;

    /// The surfaces of a vertex's path up to it, from the first.
    std::span<const PathVertex> path_to(const LightVertex& vertex) const {
        return std::span(places).subspan(vertex.place + 1 - vertex.surfaces, vertex.surfaces);
    }
    /// Which vertices each path has.
    void sort_by_path(uint32_t paths);
    /// Over the vertices; its point i is vertex order[i]. `order` is as long as those.
    HashGrid grid(float radius_m, std::span<uint32_t> order) const;
    /// Adds what the camera sees of them. `blocks`: nullptr where there are none.
    void add_splats(const PixelFilterSampler& filter, const TechniqueBlocks* blocks, PassImage& image) const;
    uint64_t bytes() const;
};

/// Borrows the scene.
class LightPathTracer {
public:
    explicit LightPathTracer(const BidirectionalScene& shared);
    ~LightPathTracer();

    /// A pure function of (scene, techniques, seed, pass), until the next call. Cancelled: it is incomplete.
    LightPaths& trace(uint64_t seed, uint32_t pass, const PassTechniques& techniques, Counts& counts,
                      const CancelToken& cancel, std::span<const WeighedCandidate> candidates = {});
    /// Of what trace() left, and of the room that it keeps for the next call.
    uint64_t bytes() const;
    static uint64_t scratch_bytes(size_t threads);

private:
    struct Shared;
    std::unique_ptr<Shared> shared_;
};

}  // namespace photond
