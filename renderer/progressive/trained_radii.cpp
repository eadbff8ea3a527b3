#include "renderer/progressive/trained_radii.h"

#include <algorithm>

#include "renderer/core/parallel.h"
#include "renderer/core/thread_local.h"
#include "renderer/eye/specular_walk.h"
#include "renderer/progressive/first_radius.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr uint32_t kPilotPasses = 4;
constexpr uint64_t kPlaces = 16'384;  // about, where radii are trained
constexpr uint32_t kTileSide = 16;
constexpr uint64_t kEyeSeed = reference_seed(0xe9e);

/// The view's shape with about kPlaces pixels, or fewer.
Size2 pilot_size(Size2 size) {
    const double share = std::sqrt(static_cast<double>(kPlaces) / static_cast<double>(size.pixels()));
    if (share >= 1) return size;
    const auto scaled = [share](uint32_t side) {
        return std::max(static_cast<uint32_t>(std::lround(share * side)), 1u);
    };
    return {scaled(size.width), scaled(size.height)};
}

/// Takes the visible points of the small image.
class Trainer final : public VisiblePointSink {
public:
    Trainer(const SpecularWalk& walk, const ProgressiveParams& params, const PerMap<PhotonMap>& pilots,
            const EstimateSettings& estimate, Neighbours& scratch, PerMap<std::vector<PlacedRadius>>& radii)
        : walk_(walk), params_(params), pilots_(pilots), estimate_(estimate), scratch_(scratch), radii_(radii) {}

    void take(std::span<const LambertVisiblePoint> lambert, std::span<const VisiblePoint> others) override {
        for (const LambertVisiblePoint& point : lambert) train(walk_.general(point));
        for (const VisiblePoint& point : others) train(point);
    }

private:
    void train(const VisiblePoint& point) {
        const uint32_t most = params_.photon_scatterings(point.scatterings + 1);
        for (const PhotonMapKind kind : kPhotonMapKinds) {
            const PhotonMap& pilot = pilots_[index_of(kind)];
            if (pilot.empty()) continue;
            if (const auto first_m = first_radius_at({point.surface, point.rough, point.wo, most}, pilot, kPilotPasses,
                                                     estimate_, scratch_))
                radii_[index_of(kind)].push_back({point.surface.position, *first_m});
        }
    }

    const SpecularWalk& walk_;
    const ProgressiveParams& params_;
    const PerMap<PhotonMap>& pilots_;
    const EstimateSettings& estimate_;
    Neighbours& scratch_;
    PerMap<std::vector<PlacedRadius>>& radii_;
};

/// What one tile found, so that the order of all does not depend on threads.
using TileRadii = PerMap<std::vector<PlacedRadius>>;

}  // namespace

TrainedRadii::TrainedRadii(const DiscRadiiInputs& inputs, Stats& stats)
    : alpha_(double{inputs.params.alpha}), limits_(inputs.context.scene.bounds.radius()) {
    const ProgressiveParams& params = inputs.params;
    PerMap<PhotonMap> pilots;
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        std::vector<Photon> photons = inputs.photons.trace_pilot(kind, kPilotPasses, stats);
        inputs.context.budget.require("radius_pilots", PhotonMap::bytes_for(photons.size()));
        const StageTimer timer(stats, "photon_map_build");
        pilots[index_of(kind)] =
            PhotonMap(std::move(photons), {PhotonSearch::Kind::Nearest, kRadiusPilotNearest, limits_.most_m});
    }

    const StageTimer timer(stats, "radius_training");
    RenderContext context = inputs.context;
    context.view.film_size = pilot_size(inputs.context.view.film_size);
    context.view.layers = LayerSet();
    context.seed = hash64(inputs.context.seed) ^ kEyeSeed;
    const EyeScene eye(context, params.sampler, params.max_scatterings());
    const EstimateSettings estimate{
        .kernel = Kernel(KernelShape::Constant), .disc_thickness_m = params.disc_thickness_m, .soft_disc = false};
    struct PerThread {
        SpecularWalk walk{kTileSide};
        Neighbours scratch;
        Counts counts;
        EyeSeconds seconds;
    };
    ThreadLocal<PerThread> threads;
    const Size2 size = context.view.film_size;
    const uint32_t columns = (size.width + kTileSide - 1) / kTileSide, rows = (size.height + kTileSide - 1) / kTileSide;
    std::vector<TileRadii> found(size_t{columns} * rows);
    PassImage image(size, context.view.layers);
    const PassSampler sampler(params.sampler, context.seed, RandomDomain::Camera, 0);
    const CancelToken never;
    parallel_over_tiles(size, kTileSide, never, [&](const Tile& tile) {
        PerThread& mine = threads.local();
        Trainer trainer(mine.walk, params, pilots, estimate, mine.scratch,
                        found[(tile.y0 / kTileSide) * columns + tile.x0 / kTileSide]);
        mine.walk.trace_tile(eye, {.glossy_threshold = params.glossy_threshold}, {sampler, {&sampler, 1}}, tile, image,
                             mine.counts, mine.seconds, never, trainer);
    });
    for (PerThread& thread : threads) stats.counts += thread.counts;

    const Kernel kernel(params.kernel, params.cone_k);
    const double wider = std::pow(double{kernel.roughness() / sqr(2 * kernel.mean_q_sq())}, 1.0 / 6);
    const double scale = wider * over_schedule(alpha_);
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        std::vector<PlacedRadius> radii;
        for (const TileRadii& tile : found)
            for (PlacedRadius place : tile[index_of(kind)]) {
                place.radius_m =
                    std::clamp(static_cast<float>(scale * double{place.radius_m}), limits_.least_m, limits_.most_m);
                radii.push_back(place);
            }
        first_m_[index_of(kind)] = RadiusMap(std::move(radii), limits_.most_m);
    }
}

void TrainedRadii::begin_pass(uint32_t pass) { share_ = radius_share(pass, alpha_); }

float TrainedRadii::radius_m(PhotonMapKind kind, const DiscPlace& place, Neighbours&) {
    return share_ * first_m_[index_of(kind)].radius_m(place.position, place.turn);
}

uint64_t TrainedRadii::bytes() const {
    uint64_t bytes = 0;
    for (const RadiusMap& map : first_m_) bytes += map.bytes();
    return bytes;
}

DiscRadiiBytes TrainedRadii::bytes_for(const ProgressiveParams& params, const Workload& workload) {
    DiscRadiiBytes bytes;
    for (const PhotonMapKind kind : kPhotonMapKinds) {
        const uint64_t photons = ProgressivePhotons::expected_photons(kind, params, workload);
        if (photons == 0) continue;
        bytes.kept += RadiusMap::bytes_for(kPlaces);
        bytes.before += PhotonMap::bytes_for(kPilotPasses * photons);
    }
    return bytes;
}

}  // namespace photond
