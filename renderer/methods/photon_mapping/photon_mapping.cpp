#include "renderer/methods/photon_mapping/photon_mapping.h"

#include "renderer/gathering/photon_gathering.h"

namespace photond {

struct PhotonMapping::State {
    State(const RenderContext& context, const PhotonMappingParams& params, Stats& stats)
        : gathering(context, params, stats), ends(SearchedRayEnds(gathering.shared(), gathering.maps())) {}

    PhotonGathering gathering;
    ThreadLocal<SearchedRayEnds> ends;
};

PhotonMapping::PhotonMapping(const PhotonMappingParams& params) : params_(params) {}
PhotonMapping::~PhotonMapping() = default;

uint64_t PhotonMapping::estimate_bytes(const PhotonMappingParams& params, const Workload& workload) {
    return PhotonGathering::estimate_bytes(params, workload);
}

void PhotonMapping::begin(const RenderContext& context, Stats& stats) {
    context.budget.require(kName, estimate_bytes(params_, workload_of(context)));
    state_ = std::make_unique<State>(context, params_, stats);
}

void PhotonMapping::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    PhotonGathering& gathering = state_->gathering;
    gathering.trace_photons(pass, stats, cancel);
    if (cancel.cancelled()) return;
    gathering.look_from_eye(
        pass, [&]() -> RayEndLookups& { return state_->ends.local(); }, {}, stats, cancel);
}

PassImage* PhotonMapping::end_pass() { return state_->gathering.end_pass(); }

std::vector<MethodArtefact> PhotonMapping::artefacts() const {
    return state_ ? state_->gathering.artefacts() : std::vector<MethodArtefact>{};
}

}  // namespace photond
