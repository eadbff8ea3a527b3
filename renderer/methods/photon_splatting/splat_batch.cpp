#include "renderer/methods/photon_splatting/splat_batch.h"

#include <algorithm>
#include <bit>

#include "renderer/core/parallel.h"
#include "renderer/transport/sampling.h"

namespace photond {

namespace {

constexpr size_t kChunkSplats = 128;

/// Makes the splats of one photon, and says which clusters they may light. One chunk's.
class SplatMaker {
public:
    SplatMaker(const SplatPass& pass, SplatBatch::Chunk& chunk)
        : pass_(pass), settings_(pass.settings), shrink_(settings_.shrink(pass.pass)), chunk_(chunk) {}

    void add(const SplatSource& source) {
        const ReflectedPhoton& photon = pass_.photons.photons[source.photon];
        const bool one_way = photon.spread() == ReflectedPhoton::Spread::Beam;
        const uint32_t rays = one_way ? 1 : pass_.params.rays_per_photon;
        RandomStream random(pass_.seed, RandomDomain::Splats, pass_.pass, source.photon);
        const vec2 offset = random.next_2d();
        for (uint32_t i = 0; i < rays; ++i)
            add_ray(source, photon, rays == 1 ? photon.direction : direction(photon, offset, i), rays, random.next());
    }

    /// Beams are as wide as they should be about the first surface their photons meet, and begin some way before it.
    void place_beams() {
        std::vector<Splat>& splats = chunk_.splats;
        rays_.clear();
        for (const Splat& splat : splats)
            if (splat.kind == Splat::Kind::Beam) rays_.push_back({splat.shadow_target, splat.axis, kInfinity});
        if (rays_.empty()) return;
        hits_.resize(rays_.size());
        pass_.intersector.closest_hits(rays_, hits_, Coherence::Incoherent);
        chunk_.counts.photon_rays += rays_.size();
        size_t ray = 0, kept = 0;
        for (const Splat& placed : splats) {
            Splat splat = placed;
            if (splat.kind == Splat::Kind::Beam) {
                const Hit& hit = hits_[ray++];
                if (!hit.valid()) continue;  // it lights nothing
                if (!place(splat, hit.t)) continue;
            }
            splats[kept++] = splat;
        }
        splats.resize(kept);
    }

    void find_clusters() {
        frusta_.clear();
        for (uint32_t i = 0; i < chunk_.splats.size(); ++i)
            chunk_.splats[i].kind == Splat::Kind::Beam ? find_of_beam(i) : find_of_connection(i);
    }

    /// Depth maps of the beams that found clusters.
    void trace_depth_maps() {
        if (frusta_.empty() || !settings_.visibility) return;
        chunk_.depth_maps = SplatDepthMaps(settings_.shadow_resolution);
        chunk_.depth_maps.trace(frusta_, pass_.intersector, chunk_.counts);
    }

private:
    /// How wide a beam is whose ray meets a surface at that distance, and where it begins and ends. False: it cannot
    /// be.
    bool place(Splat& splat, float hit_m) const {
        const BeamLanding landing{splat.origin + hit_m * splat.axis, hit_m, splat.caster};
        const float alone_m = pass_.beam_sizes.radius_m(landing, 1);
        splat.radius = shrink_ * pass_.beam_sizes.radius_m(landing, splat.weight);
        if (!settings_.normalised) splat.intensity /= sqr(splat.radius);
        if (!is_finite(splat.intensity)) return false;
        const float step_back_m = settings_.step_back_m + settings_.step_back_radii * alone_m;
        // Not before the whole bundle has left the surface it comes from, whose back would shadow it.
        const float cosine = std::max(std::fabs(glm::dot(splat.normal, splat.axis)), 1e-3f);
        const float leaves_m = splat.radius * std::sqrt(std::max(1 - sqr(cosine), 0.0f)) / cosine;
        splat.near_m = std::max(hit_m - step_back_m, std::min(leaves_m, hit_m));
        splat.far_m = std::max(hit_m - step_back_m + settings_.depth_m + settings_.depth_radii * alone_m, splat.near_m);
        return true;
    }

    void find_of_beam(uint32_t index) {
        Splat& splat = chunk_.splats[index];
        const size_t found = chunk_.found.size();
        pass_.clusters.find(
            {splat.origin, splat.axis, splat.near_m, splat.far_m, splat.radius, 0}, 0,
            [](const ShaftTarget&, int) { return 0; },
            [&](uint32_t cluster, int) {
                if (faces(pass_.clusters.clusters()[cluster], splat, true))
                    chunk_.found.push_back({cluster, index, SplatBatch::kClear});
            });
        if (chunk_.found.size() == found) return;
        splat.slot = static_cast<uint32_t>(frusta_.size());
        frusta_.push_back({splat.origin + splat.near_m * splat.axis, splat.axis, splat.radius,
                           std::max(splat.far_m - splat.near_m, 1e-6f * splat.radius)});
    }

    /// The states on the way down: what may stand in the shaft to a node, as an index into shafts_, or clear.
    void find_of_connection(uint32_t index) {
        constexpr int kSkipped = -1, kFree = 0;
        const Splat& splat = chunk_.splats[index];
        shafts_.assign(1, ShaftBlockers{});
        if (settings_.visibility) shafts_.push_back(ShaftBlockers::unknown());
        const auto enter = [&](const ShaftTarget& target, int from) {
            const float reach = glm::dot(glm::abs(splat.normal), target.half);
            // All below the horizon of y, or so little above that next to nothing gets there.
            if (glm::dot(splat.normal, target.centre - splat.origin) + reach <= 1e-5f * settings_.radius_m)
                return kSkipped;
            if (from == kFree || !pass_.shafts) return from;
            const ShaftBlockers found =
                pass_.shafts->blockers(splat.origin, splat.normal, target, shafts_[static_cast<size_t>(from)]);
            if (found.count == 0) return kFree;
            shafts_.push_back(found);
            return static_cast<int>(shafts_.size()) - 1;
        };
        const auto leaf = [&](uint32_t cluster, int state) {
            if (!faces(pass_.clusters.clusters()[cluster], splat, false)) return;
            uint32_t blockers = SplatBatch::kClear;
            if (state != kFree) {
                const ShaftBlockers& found = shafts_[static_cast<size_t>(state)];
                blockers = found.known() ? static_cast<uint32_t>(chunk_.blockers.size()) : SplatBatch::kUnknown;
                if (found.known()) keep(found);
            }
            chunk_.found.push_back({cluster, index, blockers});
        };
        pass_.clusters.find({splat.origin, splat.axis, 0, kInfinity, 0, splat.radius}, settings_.visibility ? 1 : 0,
                            enter, leaf);
    }

    void keep(const ShaftBlockers& found) {
        chunk_.blockers.push_back(found.count);
        chunk_.blockers.insert(chunk_.blockers.end(), found.triangles.begin(), found.triangles.begin() + found.count);
    }

    static bool faces(const VisibleCluster& cluster, const Splat& splat, bool beam) {
        if (splat.scatterings > cluster.most_scatterings) return false;
        if (!cluster.flat()) return true;
        return beam ? glm::dot(cluster.target.normal, splat.axis) < 0
                    : glm::dot(cluster.target.normal, splat.origin - cluster.target.centre) +
                              glm::dot(glm::abs(cluster.target.normal), cluster.target.half) >
                          0;
    }

    /// The i-th of several directions of a photon: points of a lattice, shifted for the photon, so that they are spread
    /// evenly over the hemisphere. [Roberts 2018] The Unreasonable Effectiveness of Quasirandom Sequences.
    static vec3 direction(const ReflectedPhoton& photon, const vec2& offset, uint32_t i) {
        constexpr float kBelowOne = 0x1.fffffep-1f;
        vec2 u = offset + static_cast<float>(i + 1) * vec2(0.75487766625f, 0.56984029100f);
        u = glm::min(u - glm::floor(u), vec2(kBelowOne));
        return Frame(photon.normal).to_world(sample_cosine_hemisphere(u));
    }

    void add_ray(const SplatSource& source, const ReflectedPhoton& photon, const vec3& axis, uint32_t rays, float u) {
        using Spread = ReflectedPhoton::Spread;
        Splat splat;
        splat.origin = photon.position;
        splat.axis = axis;
        splat.normal = photon.normal;
        splat.photon = source.photon;
        splat.scatterings = static_cast<uint16_t>(photon.scatterings());
        splat.weight = source.photons;
        splat.shadow_target =
            offset_ray_origin(photon.position, glm::dot(photon.normal, axis) < 0 ? -photon.normal : photon.normal);
        const bool connects = settings_.connects && photon.spread() != Spread::Beam;
        splat.radius = std::sqrt(source.photons);
        splat.disc = settings_.filter.sample_disc(u);
        Rgb power_w = source.power_w / static_cast<float>(rays);
        if (!connects) {
            splat.kind = Splat::Kind::Beam;
            splat.caster = photon.spread() == Spread::Beam ? photon.caster() : ReflectedPhoton::kMostCaster;
            if (photon.spread() == Spread::Lambert) power_w *= photon.correction_towards(axis);
            if (settings_.normalised) {
                // A colour, what the scene's surfaces would get on average if all photons were like this one, with the
                // weight it has in the mean.
                splat.intensity = power_w * (splat.weight * static_cast<float>(rays) *
                                             static_cast<float>(pass_.photons.paths) / settings_.surface_area_m2);
            }
        } else if (photon.spread() == Spread::Rough) {
            splat.kind = Splat::Kind::ConnectRough;
            const ReflectingSurface& at = pass_.photons.surfaces[photon.surface];
            const float own = max_component(photon.power_w);
            power_w = at.arriving_power_w * (own > 0 ? max_component(power_w) / own : 0);
            splat.slot = static_cast<uint32_t>(chunk_.rough.size());
            chunk_.rough.push_back(make_rough_origin(pass_.scene, at, pass_.params.photon_threshold()));
        } else {
            splat.corrected = photon.correction != 1;
        }
        if (!settings_.normalised) splat.intensity = power_w;
        if (is_black(splat.intensity) || !is_finite(splat.intensity)) return;
        chunk_.splats.push_back(splat);
    }

    const SplatPass& pass_;
    const SplatSettings& settings_;
    const float shrink_;
    SplatBatch::Chunk& chunk_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
    std::vector<SplatFrustum> frusta_;
    std::vector<ShaftBlockers> shafts_;  // of one splat; the first is empty
};

}  // namespace

void SplatBatch::make(const SplatPass& pass, size_t first, size_t last, Stats& stats, const CancelToken& cancel) {
    const double wall_start = wall_now_seconds();
    const size_t chunk_sources = std::max<size_t>(kChunkSplats / pass.params.rays_per_photon, 1);
    chunk_count_ = (last - first + chunk_sources - 1) / chunk_sources;
    if (chunks_.size() < chunk_count_) chunks_.resize(chunk_count_);
    parallel_for(chunk_count_, 1, [&](size_t c) {
        Chunk& chunk = chunks_[c];
        chunk.splats.clear(), chunk.rough.clear(), chunk.found.clear(), chunk.blockers.clear();
        chunk.counts = {};
        chunk.seconds_depth = chunk.seconds_finding = 0;
        if (cancel.cancelled()) return;
        ThreadLaps laps;
        SplatMaker maker(pass, chunk);
        const size_t begin = first + c * chunk_sources, end = std::min(begin + chunk_sources, last);
        for (size_t i = begin; i < end; ++i) {
            if (pass.sources.empty()) {
                const ReflectedPhoton& photon = pass.photons.photons[i];
                maker.add({static_cast<uint32_t>(i), photon.power_w, 1});
            } else {
                maker.add(pass.sources[i]);
            }
        }
        maker.place_beams();
        maker.find_clusters();
        laps.lap(chunk.seconds_finding);
        maker.trace_depth_maps();
        laps.lap(chunk.seconds_depth);
        chunk.counts.splats += chunk.splats.size();
    });
    double depth = 0, finding = 0;
    for (size_t c = 0; c < chunk_count_; ++c) {
        stats.counts += chunks_[c].counts;
        depth += chunks_[c].seconds_depth;
        finding += chunks_[c].seconds_finding;
    }
    sort_pairs(pass.clusters.clusters().size());
    add_interleaved_stages(stats, wall_now_seconds() - wall_start, {{"splat_depth", depth}, {"splat_find", finding}});
}

/// Counting sort by cluster: pairs of a cluster stay in the order of their chunks, and so of their splats.
void SplatBatch::sort_pairs(size_t clusters) {
    places_.assign(clusters * chunk_count_, 0);
    for (size_t c = 0; c < chunk_count_; ++c)
        for (const Chunk::Found& found : chunks_[c].found) ++places_[found.cluster * chunk_count_ + c];
    begins_.resize(clusters + 1);
    uint32_t pairs = 0;
    for (size_t i = 0; i < clusters; ++i) {
        begins_[i] = pairs;
        for (size_t c = 0; c < chunk_count_; ++c) pairs += std::exchange(places_[i * chunk_count_ + c], pairs);
    }
    begins_[clusters] = pairs;
    pairs_.resize(pairs);
    parallel_for(chunk_count_, 1, [&](size_t c) {
        for (const Chunk::Found& found : chunks_[c].found)
            pairs_[places_[found.cluster * chunk_count_ + c]++] = {found.splat, static_cast<uint32_t>(c),
                                                                   found.blockers};
    });
}

uint64_t SplatBatch::bytes() const {
    uint64_t bytes = pairs_.capacity() * sizeof(Pair) + (begins_.capacity() + places_.capacity()) * sizeof(uint32_t);
    for (const Chunk& chunk : chunks_)
        bytes += chunk.splats.capacity() * sizeof(Splat) + chunk.rough.capacity() * sizeof(RoughOrigin) +
                 chunk.found.capacity() * sizeof(Chunk::Found) + chunk.blockers.capacity() * sizeof(uint32_t);
    return bytes;
}

}  // namespace photond
