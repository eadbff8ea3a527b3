#include "renderer/methods/reverse_photon_mapping/reverse_photon_mapping.h"

#include <numeric>

#include "renderer/core/parallel.h"
#include "renderer/gathering/photon_gathering.h"
#include "renderer/methods/reverse_photon_mapping/reverse_photons.h"

namespace photond {

struct ReversePhotonMapping::State {
    State(const RenderContext& context, const ReversePhotonMappingParams& params, Stats& stats)
        : gathering(context, params, stats), ends(params.tile_points) {}

    PhotonGathering gathering;
    ThreadLocal<ReversePhotons> ends;
    PassStreams streams;  // of the pass
    StreamedImage image;
};

ReversePhotonMapping::ReversePhotonMapping(const ReversePhotonMappingParams& params) : params_(params) {}
ReversePhotonMapping::~ReversePhotonMapping() = default;

namespace {

uint64_t streamed_image_bytes(Size2 size, LayerSet layers) {
    return size.pixels() * (sizeof(Rgb) + (layers.has(Layer::PhotonCount) ? sizeof(float) : 0));
}

/// Of what photons are expected, as PhotonGathering::estimate_bytes() has them.
uint64_t streams_bytes(const ReversePhotonMappingParams& params, const Workload& workload) {
    const PhotonPlan plan = plan_of(params, workload);
    const PhotonYield yield = workload.photon_yield.value_or(kExpectedPhotonYield);
    uint64_t bytes = 0;
    if (plan.global.wanted())
        bytes += PhotonStream::bytes_for(expected_photons(params.photons, yield.global.by(params.projection_maps)),
                                         params.influence_radius);
    if (plan.caustic.wanted())
        bytes += PhotonStream::bytes_for(
            expected_photons(params.caustic_photons.value_or(params.photons), yield.caustic.by(params.projection_maps)),
            params.influence_radius);
    return bytes;
}

}  // namespace

uint64_t ReversePhotonMapping::estimate_bytes(const ReversePhotonMappingParams& params, const Workload& workload) {
    return PhotonGathering::estimate_bytes(params, workload) + streams_bytes(params, workload) +
           workload.threads * ReversePhotons::bytes_for(params.tile_points) +
           streamed_image_bytes(workload.film_size, workload.layers);
}

void ReversePhotonMapping::begin(const RenderContext& context, Stats& stats) {
    const Workload workload = workload_of(context);
    context.budget.require(kName, estimate_bytes(params_, workload));
    state_ = std::make_unique<State>(context, params_, stats);
    const Size2 size = context.view.film_size;
    state_->image.indirect.resize(size.pixels());
    if (context.view.layers.has(Layer::PhotonCount)) state_->image.photons.resize(size.pixels());
    context.budget.record("reverse_photons", workload.threads * ReversePhotons::bytes_for(params_.tile_points));
    context.budget.record("streamed_image", streamed_image_bytes(size, context.view.layers));
}

/// The photons of a map, made ready to stream.
PhotonStream ReversePhotonMapping::make_stream(const PhotonMap& map, uint32_t nearest, Stats& stats) {
    const StageTimer timer(stats, "photon_map_build");
    return {map, state_->gathering.shared().estimate, influence_radii_m(map, params_.influence_radius, nearest)};
}

void ReversePhotonMapping::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    State& state = *state_;
    PhotonGathering& gathering = state.gathering;
    state.streams = {};
    gathering.trace_photons(pass, stats, cancel);
    if (cancel.cancelled()) return;
    state.streams.global = make_stream(gathering.maps().global, params_.nearest_photons, stats);
    state.streams.caustic =
        make_stream(gathering.maps().caustic, params_.caustic_nearest_photons.value_or(params_.nearest_photons), stats);
    gathering.record("photon_streams", state.streams.global.bytes() + state.streams.caustic.bytes());

    StreamedImage& streamed = state.image;
    std::fill(streamed.indirect.begin(), streamed.indirect.end(), Rgb(0));
    std::fill(streamed.photons.begin(), streamed.photons.end(), 0.0f);
    const ReversePass reverse{gathering.shared(), gathering.maps(), state.streams, streamed, cancel};
    for (ReversePhotons& ends : state.ends) ends.start(reverse);
    const auto ends_of_thread = [&]() -> RayEndLookups& {
        bool exists = false;
        ReversePhotons& ends = state.ends.local(exists);
        if (!exists) ends.start(reverse);
        return ends;
    };
    const auto finish = [&] {
        std::vector<ReversePhotons*> tiles;
        for (ReversePhotons& ends : state.ends) tiles.push_back(&ends);
        std::vector<double> seconds(tiles.size() + 1);
        parallel_for(tiles.size(), 1, [&](size_t i) {
            ThreadLaps laps;
            tiles[i]->stream();
            laps.lap(seconds[i]);
        });
        ThreadLaps laps;
        PassImage& image = gathering.image();
        for (size_t i = 0; i < streamed.indirect.size(); ++i) image.of<Layer::Indirect>()[i] += streamed.indirect[i];
        for (size_t i = 0; i < streamed.photons.size(); ++i) image.of<Layer::PhotonCount>()[i] += streamed.photons[i];
        laps.lap(seconds.back());
        return std::accumulate(seconds.begin(), seconds.end(), 0.0);
    };
    gathering.look_from_eye(pass, ends_of_thread, finish, stats, cancel);
}

PassImage* ReversePhotonMapping::end_pass() { return state_->gathering.end_pass(); }

std::vector<MethodArtefact> ReversePhotonMapping::artefacts() const {
    return state_ ? state_->gathering.artefacts() : std::vector<MethodArtefact>{};
}

}  // namespace photond
