#pragma once
// Traces a batch of light paths together, vertex by vertex: all rays, then all shading. As methods/path_tracing does
// from the eye.

#include <array>
#include <vector>

#include "renderer/photons/photon_tracer.h"
#include "renderer/photons/reflective_shadow_map.h"
#include "renderer/photons/texel_map.h"
#include "renderer/transport/lambert_lanes.h"
#include "renderer/transport/photon_scattering.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

/// What all batches of a tracer share: prepared once, read by all threads.
struct PhotonTracingScene {
    /// How the hits of an instance are shaded.
    struct Shading {
        bool lambert;  // in lanes
        /// stores_photons(): the light that arrived where a texture is black counts in the estimate beside it.
        bool stores;
        LambertSurface surface;
    };

    /// First hits are found by `first`, all others by `later`.
    PhotonTracingScene(const Scene& scene, const Intersector& first, const Intersector& later,
                       const EmissionSampler& emission, const PhotonTracing& tracing);
    PhotonTracingScene(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
                       const PhotonTracing& tracing)
        : PhotonTracingScene(scene, intersector, intersector, emission, tracing) {}

    const Scene& scene;
    const Intersector& intersector;
    const Intersector& later_intersector;
    const EmissionSampler& emission;
    const PhotonTracing tracing;
    const Absorption absorption;
    std::vector<Shading> shading;  // by instance
};

/// Whether photons are stored wherever they arrive on that instance, also where a texture is black: where some place of
/// it may scatter diffusely, by its colour.
bool stores_photons(const Scene& scene, uint32_t instance);

/// A light path that its first hit was chosen by (vpl_tracer.h).
struct ChosenStart {
    uint32_t texel;
    float share;   // of the texel's power
    float flux_w;  // what the texel's hit reflects: roulette keeps the path's power near its share of that
};
/// Such paths, one for each element of the sequence: each starts with its texel's own numbers.
struct ChosenStarts {
    const TexelMapPass& map;
    const SequenceSampler& texel_numbers;
    std::span<const ChosenStart> starts;
};

/// Light paths that are traced together: part of one run of the sequence of numbers (SequenceSampler::kRun).
struct PhotonBatch {
    uint64_t run;
    uint32_t first, last;  // elements of the run, half open
    /// Where the paths start: those texels, counted as the sequence's elements. nullptr: by the guide or the emission.
    const ReflectiveShadowMapPass* texels = nullptr;
    const TexelMapPass* map = nullptr;     // the same of another kind of map
    const ChosenStarts* chosen = nullptr;  // or these
};

/// What a thread's batches did.
struct PhotonCounts {
    Counts counts;
    uint64_t first_hits_specular = 0;
};

/// Two-dimensional sets of random numbers: three for the emission, then two for each scattering. The first ones, which
/// are distributed best (sobol.h), go where most of the variance comes from.
enum class EmissionSet : uint32_t { Direction, Position, Light };
enum class ScatteringSet : uint32_t { Direction, RouletteAndLobe };
constexpr uint32_t sample_set(EmissionSet set) {
    constexpr uint32_t kSets[] = {0, 1, 3};
    return kSets[static_cast<uint32_t>(set)];
}
/// Beyond those of all paths, where numbers are independent: jitter that followed a sequence would repeat from row to
/// row.
inline constexpr uint32_t kJitterSet = 1u << 31;
/// `scattering` counts from 1.
constexpr uint32_t sample_set(uint32_t scattering, ScatteringSet set) {
    if (scattering == 1) return set == ScatteringSet::Direction ? 2 : 4;
    return 2 * scattering + 1 + static_cast<uint32_t>(set);
}

/// What a batch leaves where its paths are reflected. The photons' `surface` counts from the batch's first.
struct ReflectedBatch {
    std::span<const ReflectedPhoton> photons;
    std::span<const uint32_t> elements;  // of the run: whose the photons are
    std::span<const ReflectingSurface> surfaces;
};

/// What a texel of the lights' map saw.
struct SeenTexel {
    uint32_t element;  // of the run
    /// At its hit, with all of the reflected power: by Lambert or rough lobes that leave light there, of Spread::Beam
    /// and without power where none does. `direction` is the normal, and no surface is kept.
    ReflectedPhoton photon;
    /// The greatest component of what a path may carry on from there [W]: by the lobes that leave light and, if paths
    /// go on from there, by all others.
    float flux_w;
};

/// Bsdf::albedo() is a mean over all directions, which falls short at grazing ones and near a lobe. A photon of the
/// rough part is kept with at least this share of the probability that all of its power would give it, so that what
/// falls short costs at most so many times the power. Any probability above 0 is unbiased.
inline constexpr float kLeastRoughShare = 1.0f / 16;

/// Of power reflected by those lobes.
inline float flux_to_keep_by(const Rgb& power_w, const Rgb& albedo) {
    return std::max(max_component(power_w * albedo), kLeastRoughShare * max_component(power_w));
}

/// Whether power is fit to go on; counted where it is not finite.
inline bool is_sound(const Rgb& power_w, Counts& counts) {
    if (is_finite(power_w)) return true;
    const bool nan = std::isnan(power_w.x) || std::isnan(power_w.y) || std::isnan(power_w.z);
    ++(nan ? counts.nan_samples : counts.infinite_samples);
    return false;
}

/// Scratch of one thread; reused from batch to batch.
class PhotonWavefront {
public:
    static constexpr uint32_t kPaths = SequenceSampler::kRun;
    /// Of threads that call trace() alone ...
    static uint64_t bytes_per_thread();
    /// ... or trace_reflected() alone.
    static uint64_t reflection_bytes_per_thread();
    /// ... or trace_reflected() and see().
    static uint64_t texel_bytes_per_thread() { return reflection_bytes_per_thread() + kPaths * sizeof(SeenTexel); }

    PhotonWavefront();

    /// Traces the batch's paths to their ends and adds what they did to `counts`. The photons stay until the next call:
    /// ordered by scatterings, then plain Lambert reflectors before others, then by path.
    std::span<const Photon> trace(const PhotonTracingScene& shared, const SequenceSampler& sampler,
                                  const PhotonBatch& batch, PhotonCounts& counts);

    /// The same paths, up to their last scattering that counts, and what they leave there; ordered alike.
    ReflectedBatch trace_reflected(const PhotonTracingScene& shared, const SequenceSampler& sampler,
                                   const PhotonBatch& batch, Counts& counts);

    /// The first hits of the batch's texels that reflect anything; they stay until the next call.
    std::span<const SeenTexel> see(const PhotonTracingScene& shared, const SequenceSampler& sampler,
                                   const PhotonBatch& batch, Counts& counts);

private:
    /// Where photons are kept: as they arrive, as they leave, or as they would leave if none were dropped.
    enum class Record { Arrivals, Reflections, Everything };
    /// A path between two of its vertices; how many scatterings it has had all paths of the batch share.
    struct Path {
        Rgb power_w{0};
        float reference_inverse = 0;  // [1/W] of the greatest component at emission: roulette keeps the power near that
        bool rough = false;           // has had a scattering that was not specular
        bool all_delta = true;
        MediumStack media;
    };

    /// A path that may survive at a Lambert reflector, or leaves a photon there.
    struct Kept {
        uint32_t place;  // in order_
        bool stores;
        float hope;  // share of the power at emission that it may keep, but for the shading normal's correction
        Rgb reflectance;
    };
    /// A hit on any other surface, and the two parts of its BSDF.
    struct PartedHit {
        ShadingPoint point;
        vec3 wi_world;
        float outside_ior;
        Bsdf specular, rough;
    };
    /// What a path does there.
    struct PartedScattering {
        bool goes_on = false;
        bool is_rough = false;  // by the rough part
    };

    void start_paths(const PhotonTracingScene& shared, const SequenceSampler& sampler, const PhotonBatch& batch,
                     Counts& counts);
    EmissionSample start_at_texel(const ChosenStarts& chosen, const ChosenStart& start) const;
    /// No path outlives roulette for ever; chosen ones have had theirs when they come to their first hit.
    float most_survival(uint32_t scatterings) const {
        return chosen_ && scatterings == 0 ? 1.0f : ROULETTE_MOST_SURVIVAL;
    }
    void find_hits(const PhotonTracingScene& shared, uint32_t scatterings, Counts& counts);
    void advance();
    void sort_hits(const PhotonTracingScene& shared, uint32_t scatterings);
    void draw_numbers(const SequenceSampler& sampler, uint64_t run, uint32_t scatterings, size_t first);
    void ask_texels(const PhotonTracingScene& shared, size_t place);
    void keep_some(const PhotonTracingScene& shared, uint32_t scatterings, Record record);
    template <class Visit>
    void scatter_lambert(const PhotonTracingScene& shared, const Visit& visit);
    void go_on_from_lambert(uint32_t path, const Rgb& power_w, const LambertGroup& group, size_t lane);
    bool part_hit(const PhotonTracingScene& shared, uint32_t path, PartedHit& parted) const;
    PartedScattering scatter_parted(const PartedHit& parted, size_t place, bool by_rough, Counts& counts);

    void shade_lambert(const PhotonTracingScene& shared, uint32_t scatterings, Counts& counts);
    void shade_general(const PhotonTracingScene& shared, uint32_t scatterings, PhotonCounts& counts);
    bool scatter_general(const PhotonTracingScene& shared, size_t place, uint32_t scatterings, PhotonCounts& counts);
    void store(const Path& path, const vec3& position, const vec3& normal, const vec3& wi_world, uint32_t scatterings);

    void reflect_lambert(const PhotonTracingScene& shared, uint32_t scatterings, bool goes_on, Counts& counts);
    void reflect_general(const PhotonTracingScene& shared, uint32_t scatterings, bool goes_on, Counts& counts);
    bool reflect_parted(const PhotonTracingScene& shared, size_t place, uint32_t scatterings, bool goes_on,
                        Counts& counts);
    void keep_rough(const PartedHit& parted, size_t place, uint32_t scatterings, Counts& counts);
    void keep(uint32_t path, const ReflectedPhoton& photon);
    void see_parted(const PhotonTracingScene& shared, uint32_t path);

    // All of these hold kPaths but the photons; how many count is said here.
    size_t count_ = 0;  // of the paths under way
    size_t next_count_ = 0;
    std::vector<Ray> rays_, next_rays_;
    std::vector<Path> paths_, next_paths_;
    std::vector<uint32_t> elements_, next_elements_;  // of the run
    std::vector<EmissionSample> starts_;
    std::vector<float> ranges_;  // of the lights, first rays
    std::vector<Hit> hits_;
    std::vector<uint32_t> order_;  // paths that met a surface: the first lambert_count_ of them in lanes
    std::vector<uint32_t> general_;
    size_t lambert_count_ = 0;
    std::vector<Kept> kept_;
    static constexpr size_t kLookups = 32;
    std::array<TextureLookup, kLookups> lookups_{};  // of hits on Lambert reflectors, by place in order_
    struct Numbers {
        std::vector<float> x, y;
    };
    // Emission: by path; scattering: by place in order_.
    Numbers direction_, position_, choice_;
    std::vector<uint32_t> drawn_elements_;
    std::vector<Photon> photons_;  // grows
    size_t photon_count_ = 0;
    std::vector<ReflectedPhoton> reflections_;  // grow
    std::vector<uint32_t> reflection_elements_;
    std::vector<ReflectingSurface> surfaces_;
    std::vector<SeenTexel> seen_;
    bool chosen_ = false;  // the batch's paths were
};

/// Finds the surface at the hits on Lambert reflectors that were kept and draws where their paths go on, and calls
/// visit(kept, group, lane).
template <class Visit>
void PhotonWavefront::scatter_lambert(const PhotonTracingScene& shared, const Visit& visit) {
    const auto ask_corners = [&](size_t k) {
        if (k >= kept_.size()) return;
        const Hit& hit = hits_[order_[kept_[k].place]];
        shared.shading[hit.instance].surface.prefetch_corners(hit);
    };
    constexpr size_t kAhead = 24;
    for (size_t k = 0; k < kAhead; ++k) ask_corners(k);

    LambertGroup group;
    for (size_t first = 0; first < kept_.size(); first += kLanes) {
        const size_t lanes = std::min(kLanes, kept_.size() - first);
        for (size_t lane = 0; lane < kLanes; ++lane) {  // lanes past the end repeat the last path and are not read
            ask_corners(first + lane + kAhead);
            const uint32_t place = kept_[std::min(first + lane, kept_.size() - 1)].place;
            const uint32_t i = order_[place];
            group.gather(lane, shared.shading[hits_[i].instance].surface, hits_[i], rays_[i]);
            group.sample_x[lane] = direction_.x[place];
            group.sample_y[lane] = direction_.y[place];
        }
        group.find_surface();
        group.scatter_photons();
        for (size_t lane = 0; lane < lanes; ++lane) visit(kept_[first + lane], group, lane);
    }
}

}  // namespace photond
