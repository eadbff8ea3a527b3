#pragma once
// Final gathering: rays from a point the eye sees, and the light that leaves the surfaces where they end.
//
// A ray carries what f_d scatters of L_d, light that was scattered by a rough part before. At its end that is all light
// f_d scatters there: of the lights (one sample), of the caustic map, of the global map. Specular parts met on the way
// are followed; light that comes through them alone belongs to the caustic map where the ray began, and is not added.
//
// At an end that reflects more than Lambert's way, one more ray by f_d looks for lights: lobes only just too wide to be
// specular hardly ever shine at a light sample, and then much. A ray that meets a light itself is likewise one more
// sample of the direct light at the point: it is weighed against the light samples drawn there, as many as both are, by
// the power heuristic. Rays drawn by photons look elsewhere, and are not used for that.

#include <span>
#include <vector>

#include "renderer/core/cancel.h"
#include "renderer/core/stats.h"
#include "renderer/eye/visible_point.h"
#include "renderer/gathering/photon_lookup.h"
#include "renderer/gathering/split_samplers.h"
#include "renderer/photons/gather_distribution.h"
#include "renderer/transport/path_batch.h"

namespace photond {

/// A vertex of a path from the eye, whose rough part gathers light.
struct GatherPoint : VisiblePoint {
    uint32_t key;            // names its numbers
    uint32_t rays;           // split_of() the gather rays
    uint32_t light_samples;  // drawn there
};

/// What all points of a tile are gathered with.
struct GatherPass {
    const GatheringScene& shared;
    const PassMaps& maps;
    const SplitSamplers& samplers;
    RayEndLookups& ends;
    PassImage& image;
    Counts& counts;
};

/// Scratch of one thread; reused from tile to tile.
class FinalGather {
public:
    static constexpr uint32_t kRays = 4096;  // of a batch
    static uint64_t bytes_per_thread();

    FinalGather();

    /// Name of the numbers of the point that the eye path with that key reached at that vertex.
    static uint32_t key(uint32_t path_key, uint32_t vertex) { return hash32(path_key ^ (0x9e3779b9u * (vertex + 1))); }
    /// Whether rays take part in direct light.
    static bool samples_lights(const GatheringParams& params) {
        return params.final_gather() && params.gather_sampling == GatherSampling::Bsdf;
    }

    /// Adds what the points gather, or some of it when cancelled: to the indirect layer, and of direct light what
    /// samples_lights() says. What GatherPass::ends does later it adds later.
    void gather(const GatherPass& pass, std::span<const GatherPoint> points, const CancelToken& cancel);

private:
    /// The direct light of a vertex, of which a ray that meets a light there is a sample.
    struct SampledLight {
        vec3 position;  // of the vertex; with lit_normal as given to the light sampler
        vec3 lit_normal;
        float pdf_sa = 0;  // of the ray's direction, times its rays over its light samples; 0: lights do not count
    };

    /// A gather ray between two of its vertices.
    struct GatherPath {
        Rgb throughput;   // since the point
        float eta_scale;  // since the point, as in EyePath
        uint32_t point;   // index in the batch
        uint32_t scatterings;
        bool lights_only;  // what it meets scatters nothing
        SampledLight light;
        MediumStack media;
    };

    /// Radiance of a light sample, for the indirect layer.
    struct WaitingRadiance {
        Rgb radiance;
        uint32_t pixel;
    };

    void gather_batch(const GatherPass& pass, std::span<const GatherPoint> points);
    void start_rays(const GatherPass& pass, std::span<const GatherPoint> points);
    void sort_hits(const GatheringScene& shared, std::span<const GatherPoint> points, PassImage& image);
    void shade(const GatherPass& pass, const GatherPoint& origin, uint32_t vertex, uint32_t i);
    GatherPath* follow(const GatherPath& path, uint32_t ray, const ShadingPoint& surface, const BsdfSample& sample,
                       float roulette);
    static void add_direct(PassImage& image, const GatherPoint& origin, const GatherPath& path, const Rgb& radiance,
                           float light_pdf);

    // A ray's path may part at its first end, into one by the specular and one by the rough part, and each end may send
    // one more ray to look for lights. These hold kPaths; how many count is said here.
    static constexpr size_t kPaths = 4 * size_t{kRays};
    PathBatch<GatherPath> batch_{kPaths};  // keys: a ray's index among its point's, that of its sampler
    std::vector<uint64_t> order_;          // place on the Morton curve, then index
    std::vector<uint32_t> indices_;
    ShadowBatch<WaitingRadiance> shadows_{kPaths};
    // These hold kRays.
    std::vector<uint32_t> keys_;
    std::vector<float> direction_x_, direction_y_, lobe_x_, lobe_y_;
    std::vector<GatherDistribution> distributions_;  // by point, if asked for
    Neighbours neighbours_;
};

}  // namespace photond
