#pragma once
// Traces a batch of light paths together, vertex by vertex: all rays, then all shading. As the eye's batches do.
//
// These are the steps that all tracers of light paths are made of; what is kept on the way is theirs: photons as they
// arrive (photon_arrivals.h), as they leave (photon_reflections.h), or what the texels of the lights' map see
// (seen_texels.h).

#include <array>
#include <vector>

#include "renderer/photons/photon_tracing_scene.h"
#include "renderer/photons/reflective_shadow_map.h"
#include "renderer/photons/texel_map.h"
#include "renderer/transport/hit_prefetch.h"
#include "renderer/transport/path_batch.h"
#include "renderer/transport/photon_scattering.h"
#include "renderer/transport/roulette_shared.h"

namespace photond {

/// A light path that its first hit was chosen by (vpl_tracer.h).
struct ChosenStart {
    EmissionSample first;   // with the path's share of the power; black: it carries nothing
    float reflected_w = 0;  // what its hit reflects: roulette keeps the path's power near that
    uint32_t element = 0;   // of the sequence: the path's later numbers
    float choice = 0;       // of whoever chooses among what it leaves
};
/// Such paths, one for each element of the batch.
struct ChosenStarts {
    std::span<const ChosenStart> starts;
    bool elements_apart = false;  // whether those of the starts are others than their places
};

/// Light paths that are traced together.
struct PhotonBatch : SequenceRun {
    /// Where the paths start: those texels, counted as the sequence's elements. nullptr: by the guide or the emission.
    const ReflectiveShadowMapPass* texels = nullptr;
    const TexelMapPass* map = nullptr;     // the same of another kind of map
    const ChosenStarts* chosen = nullptr;  // or these
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

/// A light path between two of its vertices; how many scatterings it has had all paths of the batch share.
struct LightPath {
    Rgb power_w{0};
    float reference_inverse = 0;  // [1/W] of the greatest component at emission: roulette keeps the power near that
    bool rough = false;           // has had a scattering that was not specular
    bool all_delta = true;
    MediumStack media;
};

/// A path that may survive at a Lambert reflector, or leaves a photon there.
struct KeptPath {
    uint32_t place;  // in PhotonWavefront::order
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

/// What a tracer keeps: photons as they arrive, as they leave, or as they would leave if none were dropped.
enum class PhotonRecord { Arrivals, Reflections, Everything };

/// Scratch of one thread; reused from batch to batch.
class PhotonWavefront {
public:
    static constexpr uint32_t kPaths = SequenceSampler::kRun;
    static uint64_t bytes_per_thread();

    PhotonWavefront();

    /// The batch's paths, at their lights. Its numbers stay those of `sampler`.
    void start_paths(const PhotonTracingScene& shared, const SequenceSampler& sampler, const PhotonBatch& photons,
                     Counts& counts);
    /// Where they end; `order` has those that met a surface.
    void find_hits(const PhotonTracingScene& shared, uint32_t scatterings, Counts& counts);
    /// Numbers of all that may scatter: those from place `first` on.
    void draw_numbers(const SequenceSampler& sampler, uint64_t run, uint32_t scatterings, size_t first);

    /// Chooses the paths that may survive at plain Lambert reflectors or leave a photon, for scatter_lambert(): of the
    /// others the triangle's corners need not be fetched.
    void keep_some(const PhotonTracingScene& shared, uint32_t scatterings, PhotonRecord record);
    /// Finds the surface at those, draws where their paths go on, and calls visit(kept, group, lane).
    template <class Visit>
    void scatter_lambert(const PhotonTracingScene& shared, const Visit& visit);
    void go_on_from_lambert(uint32_t path, const Rgb& power_w, const LambertGroup& group, size_t lane);

    /// Calls visit(place in `order`) for the hits on other surfaces, one by one.
    template <class Visit>
    void visit_others(const PhotonTracingScene& shared, const Visit& visit) const;
    /// False: nothing scatters there.
    bool part_hit(const PhotonTracingScene& shared, uint32_t path, PartedHit& parted) const;
    /// Draws the next ray, by the rough part only if `by_rough`. Where the path ends, what stands in the place of the
    /// next path does not count.
    PartedScattering scatter_parted(const PartedHit& parted, size_t place, bool by_rough, Counts& counts);

    /// The greatest probability by which roulette keeps a path, so that none lives for ever. Paths chosen by their
    /// texels have passed their roulette before their first hit.
    float most_survival(uint32_t scatterings) const {
        return chosen_ && scatterings == 0 ? 1.0f : ROULETTE_MOST_SURVIVAL;
    }

    PathBatch<LightPath> batch{kPaths};  // keys: elements of the run
    std::vector<uint32_t> order;         // paths that met a surface: the first lambert_count of them in lanes
    size_t lambert_count = 0;
    // Emission: by path; scattering: by place in `order`.
    struct Numbers {
        std::vector<float> x, y;
    };
    Numbers direction, position, choice;

private:
    void sort_hits(const PhotonTracingScene& shared, uint32_t scatterings);
    void ask_texels(const PhotonTracingScene& shared, size_t place);

    std::vector<EmissionSample> starts_;
    std::vector<float> ranges_;  // of the lights, first rays
    std::vector<uint32_t> general_;
    std::vector<KeptPath> kept_;
    static constexpr size_t kLookups = 32;
    std::array<TextureLookup, kLookups> lookups_{};  // of hits on Lambert reflectors, by place in `order`
    std::vector<uint32_t> drawn_elements_;
    const ChosenStarts* chosen_ = nullptr;  // the batch's paths, if they were
};

template <class Visit>
void PhotonWavefront::scatter_lambert(const PhotonTracingScene& shared, const Visit& visit) {
    const auto ask_corners = [&](size_t k) {
        if (k >= kept_.size()) return;
        const Hit& hit = batch.hits[order[kept_[k].place]];
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
            const uint32_t i = order[place];
            group.gather(lane, shared.shading[batch.hits[i].instance].surface, batch.hits[i], batch.rays[i]);
            group.sample_x[lane] = direction.x[place];
            group.sample_y[lane] = direction.y[place];
        }
        group.find_surface();
        group.scatter_photons();
        for (size_t lane = 0; lane < lanes; ++lane) visit(kept_[first + lane], group, lane);
    }
}

template <class Visit>
void PhotonWavefront::visit_others(const PhotonTracingScene& shared, const Visit& visit) const {
    const std::span<const uint32_t> others = std::span<const uint32_t>(order).subspan(lambert_count);
    for (size_t k = 0; k < others.size(); ++k) {
        prefetch_ahead(shared.scene, batch.hits, others, k);
        visit(lambert_count + k);
    }
}

}  // namespace photond
