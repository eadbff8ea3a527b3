#include "renderer/photons/shadow_photons.h"

#include "renderer/core/parallel.h"
#include "renderer/core/rng.h"
#include "renderer/photons/photon.h"
#include "renderer/photons/radiance_estimate.h"
#include "renderer/transport/surface.h"

namespace photond {

namespace {

constexpr size_t kBatch = 1024;          // light paths that one thread follows together
constexpr uint32_t kMostSurfaces = 16;   // of one path: behind them the light is as good as out of sight
constexpr uint32_t kFewestPhotons = 10;  // of a source about a point, to tell its light from its shadow

struct Landed {
    vec3 position;
    ShadowPhotons::Mark mark;
};

/// Follows paths first ... last of the pass straight through everything they meet.
void follow(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission, uint64_t seed,
            uint32_t pass, size_t first, size_t last, std::vector<Landed>& landed, Counts& counts) {
    std::vector<Ray> rays;
    std::vector<uint32_t> sources;
    for (size_t i = first; i < last; ++i) {
        RandomStream random(seed, RandomDomain::ShadowPhotons, pass, i);
        const float u_light = random.next();
        const vec2 u_position = random.next_2d();
        EmissionSample start;
        if (!emission.sample(u_light, u_position, random.next_2d(), start)) continue;
        rays.push_back(start.ray);
        sources.push_back(start.source);
    }
    counts.photons_emitted += last - first;
    std::vector<Hit> hits(rays.size());
    for (uint32_t surface = 0; surface < kMostSurfaces && !rays.empty(); ++surface) {
        hits.resize(rays.size());
        intersector.closest_hits(rays, hits, surface == 0 ? Coherence::Coherent : Coherence::Incoherent);
        counts.photon_rays += rays.size();
        size_t kept = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            if (!hits[i].valid()) continue;
            const vec3 direction = rays[i].direction;
            const ShadingPoint point = make_plain_shading_point(scene, hits[i], direction);
            landed.push_back(
                {point.position,
                 {Octahedral<16>::encode(point.geometric_normal), sources[i] << 1 | uint32_t{surface == 0}}});
            sources[kept] = sources[i];
            rays[kept++] = {ray_origin(point, direction), direction, kInfinity};
        }
        rays.resize(kept);
        sources.resize(kept);
    }
}

}  // namespace

ShadowPhotons::ShadowPhotons(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
                             uint32_t photons, float radius_m, uint64_t seed, uint32_t pass, const CancelToken& cancel,
                             Counts& counts) {
    const size_t batches = (size_t{photons} + kBatch - 1) / kBatch;
    std::vector<std::vector<Landed>> landed(batches);
    std::vector<Counts> batch_counts(batches);
    parallel_for(batches, 1, [&](size_t b) {
        if (cancel.cancelled()) return;
        follow(scene, intersector, emission, seed, pass, b * kBatch, std::min<size_t>((b + 1) * kBatch, photons),
               landed[b], batch_counts[b]);
    });
    std::vector<vec3> points;
    std::vector<Mark> marks;
    for (size_t b = 0; b < batches; ++b) {
        counts += batch_counts[b];
        for (const Landed& photon : landed[b]) points.push_back(photon.position), marks.push_back(photon.mark);
        landed[b] = {};
    }
    counts.photons_stored += points.size();
    std::vector<uint32_t> order(points.size());
    grid_ = HashGrid(points, radius_m, order);
    marks_.resize(order.size());
    for (size_t i = 0; i < order.size(); ++i) marks_[i] = marks[order[i]];
}

LightSeen ShadowPhotons::seen(const vec3& position, const vec3& normal, uint32_t source, Neighbours& scratch) const {
    if (marks_.empty()) return LightSeen::Unknown;
    grid_.find_within(position, grid_.radius_m(), scratch);
    uint32_t lit = 0, dark = 0;
    for (const Neighbours::Found& found : scratch.found) {
        const Mark& mark = marks_[found.index];
        if (mark.source_and_lit >> 1 != source) continue;
        if (glm::dot(Octahedral<16>::decode(mark.normal), normal) < kDiscCosine) continue;
        ++(mark.source_and_lit & 1u ? lit : dark);
        if (lit > 0 && dark > 0) return LightSeen::Unknown;
    }
    if (lit + dark < kFewestPhotons) return LightSeen::Unknown;
    return lit > 0 ? LightSeen::Whole : LightSeen::Nothing;
}

uint64_t ShadowPhotons::bytes() const { return grid_.bytes() + marks_.capacity() * sizeof(Mark); }

uint64_t ShadowPhotons::bytes_for(uint64_t photons) { return HashGrid::bytes_for(photons) + photons * sizeof(Mark); }

}  // namespace photond
