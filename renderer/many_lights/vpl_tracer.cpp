#include "renderer/many_lights/vpl_tracer.h"

#include <algorithm>
#include <bit>

#include "renderer/core/parallel.h"
#include "renderer/core/thread_local.h"
#include "renderer/photons/photon_reflections.h"
#include "renderer/photons/seen_texels.h"
#include "renderer/scene/surface_area.h"

namespace photond {

namespace {

constexpr uint32_t kPathsAtOnce = 256;  // of a batch: a pass has few
constexpr uint32_t kRatedAtOnce = 32;   // as chains have fewer still at a time

PhotonTracing photon_tracing(const VplTracing& tracing) {
    PhotonTracing photons;
    photons.photons = tracing.vpls;
    photons.most_scatterings = tracing.bounces;
    photons.glossy_threshold = tracing.connect_threshold;
    photons.sampler = tracing.sampler;
    photons.beams = false;
    return photons;
}

/// What is seen by one pass's map.
struct TexelPass {
    TexelPass(const TexelMap& lights, const VplTracing& tracing, uint64_t seed, uint32_t pass)
        : map(lights, seed, pass), numbers(VplTracer::texel_numbers(tracing, map)) {}

    const TexelMapPass map;
    const SequenceSampler numbers;
};

TexelMapPass::TexelNumbers numbers_of_texel(const TexelMapPass& map, const SequenceSampler& numbers, uint32_t texel) {
    const auto of = [&](uint32_t set) { return numbers.sample_2d(texel, set); };
    return map.numbers(texel, of(kJitterSet), of(sample_set(EmissionSet::Position)),
                       of(sample_set(EmissionSet::Direction)));
}

/// What a batch of paths left, and whose it is.
struct PathLights {
    std::vector<ReflectedPhoton> photons;
    std::vector<uint32_t> paths;
    std::vector<ReflectingSurface> surfaces;
};

/// Cells of a grid over the scene that surfaces pass through, by the axis they face most.
class LitCells {
public:
    LitCells(const Bounds3& bounds, uint32_t resolution)
        : bounds_(bounds),
          resolution_(resolution),
          cell_m_(glm::max(bounds.diagonal(), vec3(1e-6f * max_component(bounds.diagonal()))) /
                  static_cast<float>(resolution)) {}

    void add(const vec3& position, const vec3& normal) {
        const vec3 facing = glm::abs(normal);
        const int axis = facing.x > facing.y ? (facing.x > facing.z ? 0 : 2) : (facing.y > facing.z ? 1 : 2);
        const uvec3 cell(glm::clamp((position - bounds_.min) / cell_m_, 0.0f, static_cast<float>(resolution_ - 1)));
        // Over the area of the cell's side a plane passes through 1 + its slopes cells of the column on the average.
        const vec3 rises = facing / cell_m_;
        const float columns = (rises.x + rises.y + rises.z) / rises[axis];
        const float side_m2 = cell_m_.x * cell_m_.y * cell_m_.z / cell_m_[axis];
        cells_.push_back({((cell.z * resolution_ + cell.y) * resolution_ + cell.x) * 6 +
                              2 * static_cast<uint32_t>(axis) + uint32_t{normal[axis] < 0},
                          side_m2 / (facing[axis] * columns)});
    }
    /// Keeps one of each.
    void merge() {
        const auto by_key = [](const Cell& a, const Cell& b) {
            return std::pair(a.key, a.area_m2) < std::pair(b.key, b.area_m2);
        };
        std::sort(cells_.begin(), cells_.end(), by_key);
        const auto same = [](const Cell& a, const Cell& b) { return a.key == b.key; };
        cells_.erase(std::unique(cells_.begin(), cells_.end(), same), cells_.end());
    }
    size_t count() const { return cells_.size(); }
    double area_m2() const {
        double area = 0;
        for (const Cell& cell : cells_) area += double{cell.area_m2};
        return area;
    }

private:
    struct Cell {
        uint32_t key;
        float area_m2;
    };
    const Bounds3 bounds_;
    const uint32_t resolution_;
    const vec3 cell_m_;
    std::vector<Cell> cells_;
};

}  // namespace

struct VplTracer::Shared : PhotonTracingScene {
    Shared(const Scene& lit_scene, const Intersector& first, const Intersector& later, const EmissionSampler& lights,
           const VplTracing& vpl_tracing)
        : PhotonTracingScene(lit_scene, first, later, lights, photon_tracing(vpl_tracing)),
          vpls(vpl_tracing),
          map(lights, vpl_tracing.map_side) {}

    /// visit(texels seen, first texel of their run), in parallel.
    template <class Visit>
    Counts see_texels(const TexelMapPass& pass, const SequenceSampler& numbers, const CancelToken& cancel,
                      const Visit& visit);
    /// The path through a texel that has that share of it.
    ChosenStart start_at(const TexelPass& pass, uint32_t texel, float share, float flux_w) const;
    ChosenPaths choose(const FluxMap& worth, const FluxMap& flux, const TexelPass& pass) const;
    ChosenPaths starts_of(std::span<const gpu::VplPath> paths, const FluxMap& flux, const TexelPass& pass) const;
    /// visit(first path of their batch, what they leave, counts), in parallel; elements count from the first path.
    template <class Visit>
    Counts follow_paths(const TexelMapPass& map, const ChosenStarts& chosen, uint32_t paths_at_once,
                        const CancelToken& cancel, const Visit& visit);
    std::vector<PhotonWorth> rate_paths(const TexelMapPass& map, const ChosenStarts& chosen, const RatePhotons& worth,
                                        Counts& counts, const CancelToken& cancel);
    TracedReflections trace_paths(const TexelMapPass& map, const ChosenPaths& paths, bool elements_apart,
                                  const CancelToken& cancel);

    const VplTracing vpls;
    const TexelMap map;
    /// Of one thread.
    struct Scratch {
        PhotonWavefront wavefront;
        SeenTexels texels;
        PhotonReflections reflections;
    };
    ThreadLocal<Scratch> threads;
};

template <class Visit>
Counts VplTracer::Shared::see_texels(const TexelMapPass& pass, const SequenceSampler& numbers,
                                     const CancelToken& cancel, const Visit& visit) {
    constexpr uint32_t kRun = SequenceSampler::kRun;
    std::vector<Counts> counts((pass.texels() + kRun - 1) / kRun);
    parallel_for(counts.size(), 1, [&](size_t i) {
        if (cancel.cancelled()) return;
        const auto first = static_cast<uint32_t>(i) * kRun;
        PhotonBatch batch{{i, 0, std::min(kRun, pass.texels() - first)}};
        batch.map = &pass;
        Scratch& mine = threads.local();
        visit(mine.texels.see(mine.wavefront, *this, numbers, batch, counts[i]), first);
    });
    Counts sum;
    for (const Counts& of_run : counts) sum += of_run;
    return sum;
}

ChosenStart VplTracer::Shared::start_at(const TexelPass& pass, uint32_t texel, float share, float flux_w) const {
    ChosenStart start;
    const TexelMapPass::TexelNumbers numbers = numbers_of_texel(pass.map, pass.numbers, texel);
    if (emission.sample_light(numbers.light, numbers.expected, numbers.u_position, numbers.u_direction, start.first))
        start.first.power_w *= share;
    else
        start.first.power_w = Rgb(0);
    start.reflected_w = flux_w * share;
    return start;
}

ChosenPaths VplTracer::Shared::choose(const FluxMap& worth, const FluxMap& flux, const TexelPass& pass) const {
    ChosenPaths paths{std::vector<ChosenStart>(vpls.vpls), std::vector<uint32_t>(vpls.vpls)};
    parallel_for(paths.starts.size(), kPathsAtOnce, [&](size_t i) {
        const Texel texel = worth.choose(rotated_halton_point(static_cast<uint32_t>(i), pass.map.rotation()));
        const float share = 1 / (static_cast<float>(vpls.vpls) * texel.probability);
        paths.starts[i] = start_at(pass, texel.index, share, flux.worth()[texel.index]);
        paths.order[i] = texel.index;
    });
    return paths;
}

ChosenPaths VplTracer::Shared::starts_of(std::span<const gpu::VplPath> paths, const FluxMap& flux,
                                         const TexelPass& pass) const {
    ChosenPaths chosen{std::vector<ChosenStart>(paths.size()), std::vector<uint32_t>(paths.size())};
    for (size_t i = 0; i < paths.size(); ++i) {
        const gpu::VplPath& path = paths[i];
        const Texel texel = flux.choose({path.point_x, path.point_y});
        const float share = path.weight / (static_cast<float>(vpls.vpls) * texel.probability);
        chosen.starts[i] = start_at(pass, texel.index, share, flux.worth()[texel.index]);
        chosen.starts[i].element = path.element, chosen.starts[i].choice = path.choice;
        chosen.order[i] = texel.index;
    }
    return chosen;
}

template <class Visit>
Counts VplTracer::Shared::follow_paths(const TexelMapPass& texels, const ChosenStarts& chosen, uint32_t paths_at_once,
                                       const CancelToken& cancel, const Visit& visit) {
    constexpr uint32_t kRun = SequenceSampler::kRun;
    const SequenceSampler numbers = path_numbers(vpls, texels);
    const auto paths = static_cast<uint32_t>(chosen.starts.size());
    std::vector<Counts> counts((paths + paths_at_once - 1) / paths_at_once);
    parallel_for(counts.size(), 1, [&](size_t i) {
        if (cancel.cancelled()) return;
        const uint32_t first = static_cast<uint32_t>(i) * paths_at_once, last = std::min(first + paths_at_once, paths);
        const uint32_t run = first / kRun, start = run * kRun;
        Scratch& scratch = threads.local();
        PhotonBatch batch{{run, first - start, last - start}};
        batch.chosen = &chosen;
        visit(start, scratch.reflections.trace(scratch.wavefront, *this, numbers, batch, counts[i]), first, counts[i]);
    });
    Counts sum;
    for (const Counts& of_batch : counts) sum += of_batch;
    return sum;
}

std::vector<PhotonWorth> VplTracer::Shared::rate_paths(const TexelMapPass& map, const ChosenStarts& chosen,
                                                       const RatePhotons& worth, Counts& counts,
                                                       const CancelToken& cancel) {
    static_assert(SequenceSampler::kRun % kRatedAtOnce == 0);
    std::vector<PhotonWorth> rated(chosen.starts.size());
    const auto rate = [&](uint32_t start, const ReflectedBatch& left, uint32_t, Counts& of_batch) {
        std::vector<uint32_t> elements(left.elements.size());
        for (size_t k = 0; k < elements.size(); ++k) elements[k] = chosen.starts[start + left.elements[k]].element;
        std::vector<PhotonWorth> brought(elements.size());
        of_batch.shadow_rays += worth(left.photons, elements, brought);
        for (size_t k = 0; k < brought.size(); ++k) {
            PhotonWorth& of_path = rated[start + left.elements[k]];
            of_path.seen += brought[k].seen;
            of_path.unshadowed += brought[k].unshadowed;
        }
    };
    const Counts of_paths = follow_paths(map, chosen, kRatedAtOnce, cancel, rate);
    // Their photons are none of the pass's.
    counts.photon_rays += of_paths.photon_rays;
    counts.shadow_rays += of_paths.shadow_rays;
    return rated;
}

TracedReflections VplTracer::Shared::trace_paths(const TexelMapPass& map, const ChosenPaths& chosen,
                                                 bool elements_apart, const CancelToken& cancel) {
    static_assert(SequenceSampler::kRun % kPathsAtOnce == 0);
    const std::span<const ChosenStart> starts = chosen.starts;
    std::vector<PathLights> batches((starts.size() + kPathsAtOnce - 1) / kPathsAtOnce);
    TracedReflections traced;
    traced.counts = follow_paths(map, {chosen.starts, elements_apart}, kPathsAtOnce, cancel,
                                 [&](uint32_t start, const ReflectedBatch& left, uint32_t first, Counts&) {
                                     PathLights& mine = batches[first / kPathsAtOnce];
                                     mine.photons.assign(left.photons.begin(), left.photons.end());
                                     mine.surfaces.assign(left.surfaces.begin(), left.surfaces.end());
                                     for (const uint32_t element : left.elements) mine.paths.push_back(start + element);
                                 });

    // Paths in their order along the map's curve; a batch has each one's photons by their scatterings.
    struct Place {
        uint32_t order, path;
        uint32_t batch, photon;
    };
    std::vector<Place> places;
    for (uint32_t b = 0; b < batches.size(); ++b) {
        for (uint32_t k = 0; k < batches[b].photons.size(); ++k) {
            const uint32_t path = batches[b].paths[k];
            places.push_back({chosen.order[path], path, b, k});
        }
    }
    std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
        return std::pair(a.order, a.path) < std::pair(b.order, b.path);
    });
    traced.photons.reserve(places.size());
    for (const Place& place : places) {
        const PathLights& batch = batches[place.batch];
        ReflectedPhoton& photon = traced.photons.emplace_back(batch.photons[place.photon]);
        if (elements_apart) traced.choices.push_back(starts[place.path].choice);
        if (photon.surface == ReflectedPhoton::kNoSurface) continue;
        traced.surfaces.push_back(batch.surfaces[photon.surface]);
        photon.surface = static_cast<uint32_t>(traced.surfaces.size() - 1);
    }
    return traced;
}

VplTracer::VplTracer(const Scene& scene, const Intersector& intersector, const Intersector& bounce_intersector,
                     const EmissionSampler& emission, const VplTracing& tracing)
    : shared_(std::make_unique<Shared>(scene, intersector, bounce_intersector, emission, tracing)) {}
VplTracer::~VplTracer() = default;

TracedReflections VplTracer::trace(uint64_t seed, uint32_t pass, const TexelImportance& importance, Stats& stats,
                                   const CancelToken& cancel) const {
    const VplTracing& tracing = shared_->vpls;
    TracedReflections traced;
    traced.paths = traced.counts.photons_emitted = tracing.vpls;
    if (tracing.bounces == 0) return traced;
    const TexelPass texels(shared_->map, tracing, seed, pass);
    FluxMap flux(shared_->map.levels());
    FluxMap weighted(importance ? shared_->map.levels() : 0);
    Counts of_texels;
    {
        const StageTimer timer(stats, "rsm");
        of_texels = shared_->see_texels(
            texels.map, texels.numbers, cancel, [&](std::span<const SeenTexel> seen, uint32_t first) {
                for (const SeenTexel& texel : seen) {
                    flux.worth()[first + texel.element] = texel.flux_w;
                    if (importance) weighted.worth()[first + texel.element] = texel.flux_w * importance(texel.photon);
                }
            });
    }
    const StageTimer timer(stats, "vpl_generation");
    flux.sum();
    if (importance) {
        weighted.sum();
        const float plain = kPlainFluxShare / flux.total(), rest = (1 - kPlainFluxShare) / weighted.total();
        if (weighted.total() > 0)
            for (uint32_t i = 0; i < flux.texels(); ++i)
                weighted.worth()[i] = plain * flux.worth()[i] + rest * weighted.worth()[i];
        else
            std::ranges::copy(flux.worth(), weighted.worth().begin());
        weighted.sum();
    }
    if (flux.total() > 0 && !cancel.cancelled()) {
        traced = shared_->trace_paths(texels.map, shared_->choose(importance ? weighted : flux, flux, texels), false,
                                      cancel);
        traced.paths = traced.counts.photons_emitted;
    }
    traced.counts += of_texels;
    return traced;
}

TracedReflections VplTracer::trace(uint64_t seed, const ChosenPaths& paths, Stats& stats,
                                   const CancelToken& cancel) const {
    const StageTimer timer(stats, "vpl_generation");
    TracedReflections traced = shared_->trace_paths({shared_->map, seed, 0}, paths, false, cancel);
    traced.paths = traced.counts.photons_emitted;
    return traced;
}

const TexelMap& VplTracer::map() const { return shared_->map; }

TexelMapPass::TexelNumbers VplTracer::numbers_of(const TexelMapPass& pass, uint32_t texel) const {
    return numbers_of_texel(pass, texel_numbers(shared_->vpls, pass), texel);
}

FluxMap VplTracer::see_flux(const TexelMapPass& pass, Counts& counts) const {
    FluxMap flux(shared_->map.levels());
    counts += shared_->see_texels(pass, texel_numbers(shared_->vpls, pass), CancelToken{},
                                  [&](std::span<const SeenTexel> seen, uint32_t first) {
                                      for (const SeenTexel& texel : seen)
                                          flux.worth()[first + texel.element] = texel.flux_w;
                                  });
    flux.sum();
    return flux;
}

void VplTracer::see(std::span<const ChosenStart> starts, std::span<float> flux_w, Counts& counts) const {
    std::ranges::fill(flux_w, 0.0f);
    PhotonBatch batch{{0, 0, static_cast<uint32_t>(starts.size())}};
    const ChosenStarts chosen{starts};
    batch.chosen = &chosen;
    Shared::Scratch& mine = shared_->threads.local();
    const SequenceSampler unused(shared_->vpls.sampler, 0, RandomDomain::Photons, 0);
    for (const SeenTexel& seen : mine.texels.see(mine.wavefront, *shared_, unused, batch, counts))
        flux_w[seen.element] = seen.flux_w;
}

TracedReflections VplTracer::trace_selected(uint64_t seed, uint32_t pass, const RatePhotons& worth,
                                            const SelectPaths& select, Stats& stats, const CancelToken& cancel) const {
    Shared& shared = *shared_;
    TracedReflections traced;
    if (shared.vpls.bounces == 0) return traced;
    const TexelPass texels(shared.map, shared.vpls, seed, pass);
    FluxMap flux(shared.map.levels());
    Counts counts;
    {
        const StageTimer timer(stats, "rsm");
        counts =
            shared.see_texels(texels.map, texels.numbers, cancel, [&](std::span<const SeenTexel> seen, uint32_t first) {
                for (const SeenTexel& texel : seen) flux.worth()[first + texel.element] = texel.flux_w;
            });
    }
    const StageTimer timer(stats, "vpl_generation");
    flux.sum();
    if (flux.total() > 0 && !cancel.cancelled()) {
        const RatePaths rate = [&](std::span<const gpu::VplPath> paths) {
            const ChosenPaths rated = shared.starts_of(paths, flux, texels);
            return shared.rate_paths(texels.map, {rated.starts, true}, worth, counts, cancel);
        };
        const SelectedPaths selected = select(texels.map.rotation(), rate);
        traced = shared.trace_paths(texels.map, shared.starts_of(selected.paths, flux, texels), true, cancel);
        traced.paths = selected.paths.size();
        counts.vpls_offered += selected.offered;
        counts.vpls_accepted += selected.accepted;
    }
    traced.counts += counts;
    return traced;
}

double VplTracer::lit_area_m2(uint64_t seed) const {
    // Of the reference's domain: its numbers are no pass's.
    const TexelPass texels(shared_->map, shared_->vpls, reference_seed(seed), 0);
    std::vector<std::vector<SeenTexel>> runs(texels.map.texels() / SequenceSampler::kRun + 1);
    shared_->see_texels(texels.map, texels.numbers, CancelToken{},
                        [&](std::span<const SeenTexel> seen, uint32_t first) {
                            for (const SeenTexel& texel : seen)
                                if (!is_black(texel.photon.power_w))
                                    runs[first / SequenceSampler::kRun].push_back(texel);
                        });
    size_t hits = 0;
    for (const std::vector<SeenTexel>& run : runs) hits += run.size();
    if (hits == 0) return 0;
    // Cells so wide that hardly any are lit without being hit.
    constexpr size_t kHitsOfCell = 8;
    double area_m2 = 0;
    for (uint32_t resolution = 64; resolution > 0; resolution /= 2) {
        LitCells cells(shared_->scene.bounds, resolution);
        for (const std::vector<SeenTexel>& run : runs)
            for (const SeenTexel& texel : run) cells.add(texel.photon.position, texel.photon.normal);
        cells.merge();
        area_m2 = cells.area_m2();
        if (cells.count() * kHitsOfCell <= hits) break;
    }
    return std::min(area_m2, surface_area_m2(shared_->scene));
}

uint64_t VplTracer::scratch_bytes(const VplTracing& tracing, size_t threads, uint64_t lights) {
    const auto levels = static_cast<uint32_t>(std::countr_zero(tracing.map_side));
    return threads * (PhotonWavefront::bytes_per_thread() + PhotonReflections::bytes_per_thread() +
                      SeenTexels::bytes_per_thread()) +
           TexelMap::bytes_for(lights) + 2 * FluxMap::values(levels) * sizeof(float) +
           tracing.vpls * (sizeof(ChosenStart) + sizeof(uint32_t));
}
uint64_t VplTracer::result_bytes(const VplTracing& tracing) {
    // Twice: in the batches, and in the order they come back in.
    return 2 * expected_vpls(tracing.vpls, tracing.bounces) *
           (sizeof(ReflectedPhoton) + sizeof(ReflectingSurface) + 16);
}

}  // namespace photond
