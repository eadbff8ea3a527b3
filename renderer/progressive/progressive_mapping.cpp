#include "renderer/progressive/progressive_mapping.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "protocol/error.h"
#include "renderer/core/thread_local.h"
#include "renderer/eye/specular_walk.h"
#include "renderer/gathering/photon_gathering.h"
#include "renderer/progressive/disc_radii.h"
#include "renderer/progressive/point_records.h"
#include "renderer/progressive/progressive_photons.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr uint32_t kTileSide = 16;

/// What all tiles of a pass read.
struct PassLookups {
    const ProgressiveParams& params;
    const EstimateSettings& estimate;
    const PerMap<PhotonMap>& maps;
    DiscRadii* radii;            // null: without photons
    const PassSampler& sampler;  // of the discs' own numbers
    float bias_factor;           // of the kernel, over the constant one's
};

/// Light of the maps that visible points scatter. One thread's.
class MapLookups final : public VisiblePointSink {
public:
    MapLookups(const PassLookups& pass, const SpecularWalk& walk, Neighbours& scratch, PassImage& image)
        : pass_(pass), walk_(walk), scratch_(scratch), image_(image) {}

    void take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) override {
        for (const LambertVisiblePoint& point : lambert) look_up(walk_.general(point));
        for (const VisiblePoint& point : others) look_up(point);
    }

private:
    void look_up(const VisiblePoint& point) {
        const uint32_t most = pass_.params.photon_scatterings(point.scatterings + 1);
        if (most == 0) return;
        const DiscPlace place{
            point.surface.position, point.pixel,
            disc_turn(pass_.sampler.sample_2d(point.path_key, sample_set(point.vertex, VertexSet::Direction)))};
        for (const PhotonMapKind kind : kPhotonMapKinds) {
            const PhotonMap& map = pass_.maps[index_of(kind)];
            if (!map.empty()) look_up(point, map, kind, place, most);
        }
    }

    void look_up(const VisiblePoint& point, const PhotonMap& map, PhotonMapKind kind, const DiscPlace& place,
                 uint32_t most_scatterings) {
        const bool shows_bias = image_.layers.has(Layer::BiasEstimate);
        DiscMoments moments{.channels = kLuminanceWeights * point.throughput};
        const float radius_m = pass_.radii->radius_m(kind, place, scratch_);
        const DiscQuery query{.turn = place.turn,
                              .care = DiscCare::Coarse,  // passes are averaged
                              .radius_m = radius_m,
                              .moments = shows_bias || pass_.radii->wants_moments() ? &moments : nullptr};
        const RadianceEstimate found = estimate_radiance(map, pass_.estimate, point.surface, point.rough, point.wo,
                                                         most_scatterings, scratch_, query);
        pass_.radii->gathered(kind, place, found, moments);
        image_.of<Layer::Indirect>()[point.pixel] += point.throughput * found.radiance;
        if (kind == PhotonMapKind::Caustic && point.scatterings == 0 && image_.layers.has(Layer::Caustic))
            image_.of<Layer::Caustic>()[point.pixel] += point.throughput * found.delta_radiance;
        if (image_.layers.has(Layer::PhotonCount))
            image_.of<Layer::PhotonCount>()[point.pixel] += static_cast<float>(found.photons);
        // In light that varies quadratically the constant kernel is 3 sum w t / (pi r^2) too bright.
        if (shows_bias)
            image_.of<Layer::BiasEstimate>()[point.pixel] +=
                pass_.bias_factor * static_cast<float>(3 * moments.w_t * double{kInvPi}) / sqr(radius_m);
        if (image_.layers.has(Layer::Radius)) {
            // The largest of both maps' radii at all of the pixel's points.
            float& shown_m = image_.of<Layer::Radius>()[point.pixel];
            shown_m = std::max(shown_m, radius_m);
        }
    }

    const PassLookups& pass_;
    const SpecularWalk& walk_;
    Neighbours& scratch_;
    PassImage& image_;
};

uint64_t scratch_bytes(size_t threads) { return threads * SpecularWalk::bytes_per_thread(kTileSide); }

}  // namespace

struct ProgressiveMapping::State {
    struct PerThread {
        SpecularWalk walk{kTileSide};
        Neighbours scratch;
        Counts counts;
        EyeSeconds seconds;
    };

    State(const RenderContext& context, const ProgressiveParams& params)
        : eye(context, params.sampler, params.max_scatterings()),
          estimate{.kernel = Kernel(params.kernel, params.cone_k),
                   .disc_thickness_m = params.disc_thickness_m,
                   .soft_disc = false},
          image(context.view.film_size, context.view.layers) {}

    const EyeScene eye;
    EstimateSettings estimate;
    std::optional<DiscCoverage> coverage;
    std::optional<ProgressivePhotons> photons;
    std::unique_ptr<DiscRadii> radii;
    ThreadLocal<PerThread> threads;
    PassImage image;
    bool pass_complete = false;  // image holds a whole pass
    bool pass_counted = false;   // and the radii know of it
};

ProgressiveMapping::ProgressiveMapping(std::unique_ptr<const ProgressiveParams> params, uint32_t eye_passes)
    : params_(std::move(params)), eye_passes_(eye_passes) {}
ProgressiveMapping::~ProgressiveMapping() = default;

uint64_t ProgressiveMapping::estimate_bytes(const ProgressiveParams& params, uint32_t eye_passes,
                                            const Workload& workload) {
    const DiscRadiiBytes radii = disc_radii_bytes(params, std::max(eye_passes, 1u), workload);
    uint64_t bytes = PassImage::bytes_for(workload.film_size, workload.layers) + scratch_bytes(workload.threads) +
                     LightSampler::estimate_bytes(workload.lights, workload.environment_size) + radii.kept +
                     std::max(ProgressivePhotons::estimate_bytes(params, workload), radii.before);
    if (params.boundary == DiscBoundary::Clip) bytes += EdgeTree::estimate_bytes(workload.triangles);
    return bytes;
}

uint64_t ProgressiveMapping::estimate_state_bytes(const ProgressiveParams& params, uint32_t eye_passes,
                                                  const Workload& workload) {
    return disc_radii_bytes(params, std::max(eye_passes, 1u), workload).state;
}

void ProgressiveMapping::go_on_from(const std::string& state) {
    check_points_to_go_on_from(*params_, state);
    state_before_ = state;
}

void ProgressiveMapping::begin(const RenderContext& context, Stats& stats) {
    const Scene& scene = context.scene;
    MemoryBudget& budget = context.budget;
    budget.require("progressive_mapping", estimate_bytes(*params_, eye_passes_, workload_of(context)));

    state_ = std::make_unique<State>(context, *params_);
    State& state = *state_;
    budget.record("pass_image", PassImage::bytes_for(context.view.film_size, context.view.layers));
    budget.record("wavefronts", scratch_bytes(most_threads()));
    budget.record("light_sampler", state.eye.lights.bytes());
    if (!scene.needs.solid_glass) stats.skipped.push_back({"absorption", "no solid refracts", 0});
    state.photons.emplace(context, *params_, stats);
    if (!state.photons->any()) {
        state.photons.reset();
        return;
    }
    state.radii = make_disc_radii({.context = context,
                                   .params = *params_,
                                   .photons = *state.photons,
                                   .hit_point_sets = std::max(eye_passes_, 1u),
                                   .state = state_before_},
                                  stats);
    budget.record("radii", state.radii->bytes());
    if (params_->boundary == DiscBoundary::Clip) {
        const float most_m =
            params_->first_radius_m(scene.bounds.radius()).value_or(RadiusLimits(scene.bounds.radius()).most_m);
        state.estimate.coverage = &state.coverage.emplace(scene, *context.intersector, most_m);
        budget.record("disc_coverage", state.coverage->bytes());
    }
}

void ProgressiveMapping::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    state.pass_complete = state.pass_counted = false;
    PerMap<PhotonMap> maps;
    if (state.photons) {
        state.radii->begin_pass(pass);
        for (const PhotonMapKind kind : kPhotonMapKinds) {
            const std::optional<float> radius_m = state.radii->grid_radius_m(kind);
            // A tree where radii differ: a grid is as slow everywhere as its largest radius is.
            const PhotonSearch search = radius_m ? PhotonSearch{PhotonSearch::Kind::Radius, 2, *radius_m}
                                                 : PhotonSearch{PhotonSearch::Kind::Nearest, 2, 1};
            maps[index_of(kind)] = state.photons->trace(kind, pass, search, stats, cancel);
        }
        if (cancel.cancelled()) return;
    }

    const double wall_start = wall_now_seconds();
    const EyeScene& eye = state.eye;
    const PassSampler fresh(eye.sampler, eye.seed, RandomDomain::Camera, pass);
    std::optional<PassSampler> fixed;
    if (eye_passes_ > 0) fixed.emplace(eye.sampler, eye.seed, RandomDomain::Camera, pass % eye_passes_);
    const PassSampler& path = fixed ? *fixed : fresh;
    const PassLookups lookups{*params_,          state.estimate, maps,
                              state.radii.get(), fresh,          2 * state.estimate.kernel.mean_q_sq()};
    parallel_over_tiles(eye.view.film_size, kTileSide, cancel, [&](const Tile& tile) {
        State::PerThread& mine = state.threads.local();
        MapLookups sink(lookups, mine.walk, mine.scratch, state.image);
        mine.walk.trace_tile(eye, {.glossy_threshold = params_->glossy_threshold}, {path, {&fresh, 1}}, tile,
                             state.image, mine.counts, mine.seconds, cancel, sink);
    });
    const EyeSeconds cpu = take_work(state.threads, stats);
    add_interleaved_stages(
        stats, wall_now_seconds() - wall_start,
        {{"g_buffer", cpu.camera}, {"direct", cpu.direct}, {"indirect", cpu.indirect}, {"gather", cpu.points}});
    state.pass_complete = !cancel.cancelled();
}

PassImage* ProgressiveMapping::end_pass() {
    State& state = *state_;
    if (!state.pass_complete) return nullptr;
    if (state.radii && !std::exchange(state.pass_counted, true)) state.radii->end_pass();
    return &state.image;
}

std::string ProgressiveMapping::state() const {
    if (params_->passes_stand_alone()) return {};
    if (!state_) return state_before_;
    return state_->radii ? state_->radii->state() : kNoPoints;
}

}  // namespace photond
