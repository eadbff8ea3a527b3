#include "renderer/photons/projection_map.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "renderer/core/parallel.h"
#include "renderer/core/rng.h"
#include "renderer/photons/emission_grid.h"
#include "renderer/photons/projection_map_shared.h"
#include "renderer/scene/scene.h"
#include "renderer/transport/bsdf.h"
#include "renderer/transport/discrete_distribution.h"

namespace photond {

namespace {

constexpr uint32_t kMostGuidedLights = 256;  // the strongest; the others are chosen by power and looked at as a group
constexpr uint32_t kBins = 65536;            // shared among guided lights by power ...
constexpr int kLeastLevels = 3;              // ... at 4^3 to 4^7 bins each
constexpr int kMostLevels = 7;
constexpr uint32_t kFirstRays = 2;      // into every bin
constexpr uint32_t kMoreRays = 8;       // into bins that saw what is looked for, and about them
constexpr int kMostRounds = 4;          // of following the outlines of what was seen
constexpr uint32_t kRestRays = 4096;    // for all lights without bins together
constexpr uint32_t kFirstLook = 4096;   // unguided ones: whether so many meet any surface that no bins are needed
constexpr uint32_t kCheckRays = 4096;   // guided ones, to measure what guiding does
constexpr double kUnguidedShare = 0.1;  // of the photons: no power exceeds its inverse times the unguided one

// The tracer's passes never get so far: pilot rays share no numbers with photons.
constexpr uint32_t kPilotPass = UINT32_MAX;
constexpr uint32_t kRestPass = UINT32_MAX - 1;
constexpr uint32_t kCheckPass = UINT32_MAX - 2;
constexpr uint32_t kFirstPass = UINT32_MAX - 3;

constexpr size_t kBatch = 1024;  // rays

/// Guiding helps where it doubles the share of first hits on the target; no share can be doubled beyond 1.
bool can_help(double unguided_share) { return unguided_share > 0 && unguided_share <= 0.5; }

/// What pilot rays of one bin (or group of lights) found: sums; powers are unguided ones over the scene's.
struct Found {
    uint32_t rays = 0;
    uint32_t target_rays = 0;  // whose first hit is what is looked for
    float power = 0;
    float target_power = 0;    // of these
    float target_squares = 0;  // power^2 x reflectance by the lobes that count

    Found& operator+=(const Found& more) {
        rays += more.rays, target_rays += more.target_rays;
        power += more.power, target_power += more.target_power, target_squares += more.target_squares;
        return *this;
    }
};

/// Follows rays from the lights to their first hit.
class Pilot {
public:
    Pilot(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission, ProjectionTarget target,
          float glossy_threshold)
        : scene_(scene),
          intersector_(intersector),
          target_(target),
          glossy_threshold_(glossy_threshold),
          per_scene_power_(1 / emission.total_power_w()) {}

    /// What `rays_each` rays each of `count` bins find. draw(i, k, sample): ray k of bin i, false for a sample that
    /// carries nothing.
    template <class Draw>
    std::vector<Found> trace(size_t count, uint32_t rays_each, const Draw& draw) const {
        std::vector<Found> found(count);
        const size_t in_batch = std::max<size_t>(1, kBatch / rays_each);
        parallel_for((count + in_batch - 1) / in_batch, 1, [&](size_t batch) {
            const size_t first = batch * in_batch, bins = std::min(in_batch, count - first);
            std::vector<EmissionSample> samples(bins * rays_each);
            std::vector<Ray> rays(samples.size());
            std::vector<Hit> hits(samples.size());
            for (size_t i = 0; i < samples.size(); ++i) {
                const uint32_t ray = static_cast<uint32_t>(i % rays_each);
                const bool carries = draw(first + i / rays_each, ray, samples[i]);
                rays[i] = carries ? samples[i].ray : Ray{vec3(0), vec3(0, 0, 1), 0.0f};
            }
            intersector_.closest_hits(rays, hits, Coherence::Incoherent);
            for (size_t i = 0; i < samples.size(); ++i) {
                Found& bin = found[first + i / rays_each];
                ++bin.rays;
                if (rays[i].t_max > 0) add(samples[i], hits[i], bin);
            }
        });
        return found;
    }

private:
    void add(const EmissionSample& sample, const Hit& hit, Found& found) const {
        float power = static_cast<float>(mean(sample.power_w) * per_scene_power_);
        if (hit.valid()) power *= range_window(hit.t, sample.range_m);
        found.power += power;
        if (!hit.valid() || !(power > 0)) return;
        const ShadingPoint point = make_shading_point(scene_, hit, sample.ray.direction);
        Bsdf counts = make_bsdf(scene_, point);
        if (target_ == ProjectionTarget::SpecularSurfaces) counts = counts.specular_part(glossy_threshold_);
        if (!counts.scatters()) return;
        ++found.target_rays;
        found.target_power += power;
        found.target_squares += power * power * std::min(1.0f, mean(counts.albedo()));
    }

    const Scene& scene_;
    const Intersector& intersector_;
    ProjectionTarget target_;
    float glossy_threshold_;
    double per_scene_power_;
};

}  // namespace

struct ProjectionMap::Bins {
    explicit Bins(const EmissionSampler& lights) : emission(lights) {}

    const EmissionSampler& emission;
    std::vector<EmissionGrid> grids;  // first_bin rising
    uint32_t guided_bins = 0;         // of all grids; after them one bin for each light in `rest`
    std::vector<uint32_t> rest;       // lights without a grid
    DiscreteDistribution choice;      // of a bin
    ProjectionTarget target{};
    double unguided_share = 0;
    double guided_share = 0;
    uint64_t pilot_rays = 0;

    const EmissionGrid& grid_of(uint32_t bin) const {
        const auto after = std::upper_bound(grids.begin(), grids.end(), bin,
                                            [](uint32_t b, const EmissionGrid& grid) { return b < grid.first_bin; });
        return *(after - 1);
    }
    /// A sample within a bin that is chosen with that probability.
    bool sample_bin(const EmissionGrid& grid, uint32_t bin, float probability, const vec2& u_position,
                    const vec2& u_direction, EmissionSample& out) const {
        const EmissionGrid::Bin at = grid.bin(bin - grid.first_bin);
        return emission.sample_light(grid.light, probability * static_cast<float>(grid.resolution.bins()),
                                     into_cell(at.place, grid.resolution.places, u_position),
                                     into_cell(at.direction, grid.resolution.directions, u_direction), out);
    }
    bool sample(float u_select, const vec2& u_position, const vec2& u_direction, EmissionSample& out) const {
        if (choice.empty()) return false;
        const uint32_t bin = choice.sample(u_select);
        const float probability = choice.probability(bin);
        if (bin < guided_bins) return sample_bin(grid_of(bin), bin, probability, u_position, u_direction, out);
        return emission.sample_light(rest[bin - guided_bins], probability, u_position, u_direction, out);
    }
    double unguided_probability(uint32_t bin) const {
        if (bin >= guided_bins) return emission.probability(rest[bin - guided_bins]);
        const EmissionGrid& grid = grid_of(bin);
        return emission.probability(grid.light) / static_cast<double>(grid.resolution.bins());
    }

    bool most_meet_target(const Pilot& pilot, uint64_t seed);
    void divide_lights(const Scene& scene, bool into_bins);
    std::vector<Found> look(const Pilot& pilot, uint64_t seed);
    std::vector<Found> look_into(std::span<const uint32_t> bins, uint32_t first_ray, uint32_t rays, const Pilot& pilot,
                                 uint64_t seed);
    void follow_outlines(std::vector<Found>& found, const Pilot& pilot, uint64_t seed);
    Found look_at_rest(const Pilot& pilot, uint64_t seed);
    void prefer(std::span<const Found> found);
    void check(const Pilot& pilot, uint64_t seed);
    double share_seen(std::span<const Found> found) const;

    /// Calls visit(other bin) for the bins beside one in direction or in place. Both squares count as closed to tori,
    /// which some of the maps make them; for the others it costs a few bins.
    template <class Visit>
    void visit_neighbours(uint32_t bin, const Visit& visit) const {
        const EmissionGrid& grid = grid_of(bin);
        const EmissionGrid::Bin at = grid.bin(bin - grid.first_bin);
        for (uint32_t dy = 0; dy < 3; ++dy)
            for (uint32_t dx = 0; dx < 3; ++dx) {
                const auto beside = [&](const uvec2& cell, uint32_t count) {
                    return uvec2((cell.x + dx + count - 1) % count, (cell.y + dy + count - 1) % count);
                };
                visit(grid.first_bin + grid.index({at.place, beside(at.direction, grid.resolution.directions)}));
                visit(grid.first_bin + grid.index({beside(at.place, grid.resolution.places), at.direction}));
            }
    }
};

/// By a few unguided rays, which then stand for the share. Not for what may be so small that they all miss it.
bool ProjectionMap::Bins::most_meet_target(const Pilot& pilot, uint64_t seed) {
    if (target == ProjectionTarget::SpecularSurfaces) return false;
    const std::vector<Found> each = pilot.trace(kFirstLook, 1, [&](size_t i, uint32_t, EmissionSample& sample) {
        RandomStream random(seed, RandomDomain::Photons, kFirstPass, i);
        const float u_select = random.next();
        const vec2 u_position = random.next_2d(), u_direction = random.next_2d();
        return emission.sample(u_select, u_position, u_direction, sample);
    });
    pilot_rays += kFirstLook;
    Found all;
    for (const Found& one : each) all += one;
    if (!(all.power > 0)) return false;
    unguided_share = guided_share = double{all.target_power} / double{all.power};
    return unguided_share > 0.5;
}

/// Bins for the strongest lights, where they are wanted.
void ProjectionMap::Bins::divide_lights(const Scene& scene, bool into_bins) {
    std::vector<uint32_t> lights;
    for (uint32_t light = 0; light < emission.lights(); ++light)
        if (emission.probability(light) > 0) lights.push_back(light);
    const size_t guided = into_bins ? std::min<size_t>(lights.size(), kMostGuidedLights) : 0;
    std::partial_sort(lights.begin(), lights.begin() + static_cast<std::ptrdiff_t>(guided), lights.end(),
                      [&](uint32_t a, uint32_t b) {
                          const float pa = emission.probability(a), pb = emission.probability(b);
                          return pa != pb ? pa > pb : a < b;
                      });
    double guided_power = 0;
    for (size_t i = 0; i < guided; ++i) guided_power += emission.probability(lights[i]);
    for (size_t i = 0; i < guided; ++i) {
        const double bins = kBins * (emission.probability(lights[i]) / guided_power);
        const int levels = std::clamp(static_cast<int>(std::floor(0.5 * std::log2(bins))), kLeastLevels, kMostLevels);
        grids.push_back({lights[i], guided_bins, emission_resolution(scene, lights[i], levels)});
        guided_bins += grids.back().resolution.bins();
    }
    rest.assign(lights.begin() + static_cast<std::ptrdiff_t>(guided), lights.end());
}

/// Traces rays number first_ray, first_ray + 1 ... of those bins.
std::vector<Found> ProjectionMap::Bins::look_into(std::span<const uint32_t> bins, uint32_t first_ray, uint32_t rays,
                                                  const Pilot& pilot, uint64_t seed) {
    pilot_rays += bins.size() * rays;
    return pilot.trace(bins.size(), rays, [&](size_t i, uint32_t k, EmissionSample& sample) {
        const uint32_t bin = bins[i], ray = first_ray + k;
        RandomStream random(seed, RandomDomain::Photons, kPilotPass, uint64_t{bin} << 32 | ray);
        // Ray after ray another quarter of the direction's cell, those across first, and of the place's in an order of
        // the bin's own.
        const auto quarter = [&](uint32_t q) { return into_cell(uvec2((q ^ q >> 1) & 1, q & 1), 2, random.next_2d()); };
        const vec2 u_direction = quarter(ray), u_position = quarter(ray ^ hash32(bin));
        const EmissionGrid& grid = grid_of(bin);
        const float unguided = emission.probability(grid.light) / static_cast<float>(grid.resolution.bins());
        return sample_bin(grid, bin, unguided, u_position, u_direction, sample);
    });
}

/// Traces the pilot rays: what each bin saw and, last, what the lights without bins did together.
std::vector<Found> ProjectionMap::Bins::look(const Pilot& pilot, uint64_t seed) {
    std::vector<uint32_t> all(guided_bins);
    std::iota(all.begin(), all.end(), 0u);
    std::vector<Found> found = look_into(all, 0, kFirstRays, pilot, seed);
    found.push_back(rest.empty() ? Found{} : look_at_rest(pilot, seed));
    // By the first rays alone: where more follow depends on what these saw, and all together would see too little.
    unguided_share = guided_share = share_seen(found);
    if (can_help(unguided_share)) follow_outlines(found, pilot, seed);
    return found;
}

/// More rays where the target was seen and next to it, then next to what these rays see.
void ProjectionMap::Bins::follow_outlines(std::vector<Found>& found, const Pilot& pilot, uint64_t seed) {
    std::vector<uint32_t> bins;
    for (int round = 0; round < kMostRounds; ++round) {
        bins.clear();
        for (uint32_t bin = 0; bin < guided_bins; ++bin) {
            if (found[bin].rays > kFirstRays) continue;
            bool near = false;
            visit_neighbours(bin, [&](uint32_t other) { near |= found[other].target_rays > 0; });
            if (near) bins.push_back(bin);
        }
        if (bins.empty()) return;
        const std::vector<Found> more = look_into(bins, kFirstRays, kMoreRays, pilot, seed);
        for (size_t i = 0; i < bins.size(); ++i) found[bins[i]] += more[i];
    }
}

Found ProjectionMap::Bins::look_at_rest(const Pilot& pilot, uint64_t seed) {
    std::vector<double> weights;
    for (const uint32_t light : rest) weights.push_back(emission.probability(light));
    const DiscreteDistribution of_rest(weights);
    pilot_rays += kRestRays;
    const std::vector<Found> each = pilot.trace(kRestRays, 1, [&](size_t i, uint32_t, EmissionSample& sample) {
        RandomStream random(seed, RandomDomain::Photons, kRestPass, i);
        const uint32_t light = rest[of_rest.sample(random.next())];
        const vec2 u_position = random.next_2d(), u_direction = random.next_2d();
        return emission.sample_light(light, emission.probability(light), u_position, u_direction, sample);
    });
    Found group;
    for (const Found& one : each) group += one;
    return group;
}

/// Power-weighted share of first hits on the target.
double ProjectionMap::Bins::share_seen(std::span<const Found> found) const {
    double power = 0, target_power = 0;
    for (uint32_t bin = 0; bin < guided_bins + rest.size(); ++bin) {
        const Found& seen = found[std::min(bin, guided_bins)];
        const double each = unguided_probability(bin) / seen.rays;
        power += each * seen.power;
        target_power += each * seen.target_power;
    }
    return power > 0 ? target_power / power : 0;
}

/// The probability of each bin: the unguided share of its own, and the rest in proportion to the root mean square of
/// the power that goes on from the target, which gives photons the least variance. Nothing was looked at or can help:
/// its own.
void ProjectionMap::Bins::prefer(std::span<const Found> found) {
    const size_t bins = guided_bins + rest.size();
    std::vector<double> unguided(bins);
    for (uint32_t bin = 0; bin < bins; ++bin) unguided[bin] = unguided_probability(bin);
    if (!can_help(unguided_share)) {
        choice = DiscreteDistribution(unguided);
        return;
    }
    std::vector<double> weights(bins), least(bins);
    for (uint32_t bin = 0; bin < bins; ++bin) {
        const Found& seen = found[std::min(bin, guided_bins)];
        double squares = seen.target_squares;
        if (bin < guided_bins && seen.target_rays == 0) {
            // As if a quarter of a ray had met what neighbours met.
            visit_neighbours(bin, [&](uint32_t other) {
                const Found& there = found[other];
                if (there.target_rays > 0) squares = std::max(squares, 0.25 * there.target_squares / there.target_rays);
            });
        }
        weights[bin] = unguided[bin] * std::sqrt(squares / seen.rays);
        least[bin] = unguided[bin] * kUnguidedShare;
    }
    choice = DiscreteDistribution(weights, least);
}

/// What became of it, by new rays: those that chose the bins would praise them too much.
void ProjectionMap::Bins::check(const Pilot& pilot, uint64_t seed) {
    const std::vector<Found> found = pilot.trace(kCheckRays, 1, [&](size_t i, uint32_t, EmissionSample& drawn) {
        RandomStream random(seed, RandomDomain::Photons, kCheckPass, i);
        const float u_select = random.next();
        const vec2 u_position = random.next_2d(), u_direction = random.next_2d();
        return sample(u_select, u_position, u_direction, drawn);
    });
    pilot_rays += kCheckRays;
    uint32_t on_target = 0;
    for (const Found& one : found) on_target += one.target_rays;
    guided_share = on_target / double{kCheckRays};
}

ProjectionMap::ProjectionMap(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
                             ProjectionTarget target, float glossy_threshold, uint64_t seed) {
    auto bins = std::make_unique<Bins>(emission);
    bins->target = target;
    if (emission.total_power_w() > 0) {
        const Pilot pilot(scene, intersector, emission, target, glossy_threshold);
        const bool there = target == ProjectionTarget::Surfaces || scene.needs.delta || scene.needs.glossy;
        const bool look = there && !bins->most_meet_target(pilot, seed);
        bins->divide_lights(scene, look);
        bins->prefer(look ? bins->look(pilot, seed) : std::vector<Found>{});
        if (can_help(bins->unguided_share)) bins->check(pilot, seed);
    }
    bins_ = std::move(bins);
}

ProjectionMap::~ProjectionMap() = default;
ProjectionMap::ProjectionMap(ProjectionMap&&) noexcept = default;

double ProjectionMap::unguided_share() const { return bins_->unguided_share; }
double ProjectionMap::guided_share() const { return bins_->guided_share; }
bool ProjectionMap::has_bins() const { return bins_->guided_bins > 0; }
bool ProjectionMap::helps() const { return can_help(unguided_share()) && guided_share() >= 2 * unguided_share(); }

std::string ProjectionMap::text() const {
    const char* const what = bins_->target == ProjectionTarget::Surfaces ? "a surface" : "specular surfaces";
    char text[160];
    std::snprintf(text, sizeof text, "%.1f %% of the photons meet %s unguided, %.1f %% would guided",
                  100 * unguided_share(), what, 100 * guided_share());
    return text;
}

bool ProjectionMap::sample(float u_select, const vec2& u_position, const vec2& u_direction, EmissionSample& out) const {
    return bins_->sample(u_select, u_position, u_direction, out);
}

ProjectionMap::DeviceTables ProjectionMap::device_tables() const {
    const Bins& bins = *bins_;
    DeviceTables tables;
    std::vector<uint32_t>& words = tables.words;
    words.resize(GUIDE_HEADER);
    for (const EmissionGrid& grid : bins.grids)
        words.insert(words.end(), {grid.light, grid.first_bin, grid.resolution.places, grid.resolution.directions});
    words[GUIDE_GRIDS] = static_cast<uint32_t>(bins.grids.size());
    words[GUIDE_BINS] = bins.guided_bins;
    words[GUIDE_REST] = static_cast<uint32_t>(words.size());
    words.insert(words.end(), bins.rest.begin(), bins.rest.end());
    words[GUIDE_CHOICE] = static_cast<uint32_t>(words.size());
    const std::span<const uint32_t> guide = bins.choice.guide();
    words[GUIDE_CHOICES] = guide.empty() ? 0 : static_cast<uint32_t>(guide.size() - 1);
    words.insert(words.end(), guide.begin(), guide.end());
    tables.cdf.assign(bins.choice.cdf().begin(), bins.choice.cdf().end());
    return tables;
}

uint64_t ProjectionMap::pilot_rays() const { return bins_->pilot_rays; }

uint64_t ProjectionMap::bytes() const {
    return sizeof(Bins) + bins_->grids.capacity() * sizeof(EmissionGrid) + bins_->rest.capacity() * sizeof(uint32_t) +
           bins_->choice.bytes();
}

uint64_t ProjectionMap::estimate_bytes(uint64_t lights) {
    const uint64_t guided = std::min<uint64_t>(lights, kMostGuidedLights);
    const uint64_t bins = std::min(guided << 2 * kMostLevels, kBins + (guided << 2 * kLeastLevels));
    constexpr uint64_t kBuilding = 2 * sizeof(Found) + 3 * sizeof(double) + 2 * sizeof(uint32_t);
    return sizeof(Bins) + guided * sizeof(EmissionGrid) + (lights - guided) * sizeof(uint32_t) +
           DiscreteDistribution::bytes_for(bins + lights - guided) + bins * kBuilding +
           (lights - guided) * 4 * sizeof(double);
}

}  // namespace photond
