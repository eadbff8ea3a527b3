#include "renderer/photons/photons_ahead.h"

#include "renderer/core/parallel.h"

namespace photond {

void PhotonsAhead::add(const Scene& scene, const Intersector& intersector, const EmissionSampler& emission,
                       const PhotonTracing& tracing) {
    tracers_[static_cast<size_t>(tracing.kind)].emplace(scene, intersector, emission, tracing);
}

uint64_t PhotonsAhead::bytes() const {
    uint64_t bytes = 0;
    if (here_)
        for (const TracedPhotons& traced : here_->of_map) bytes += 2 * traced.photons.capacity() * sizeof(Photon);
    return bytes;
}

void PhotonsAhead::begin(uint32_t pass) {
    if (begun_ == pass) return;
    stop();
    given_up_.emplace();
    under_way_ = run_beside([this, pass] {
        Pass traced{.index = pass, .of_map = {}};
        for (size_t map = 0; map < kMaps; ++map)
            if (tracers_[map]) traced.of_map[map] = tracers_[map]->trace(seed_, pass, *given_up_);
        return traced;
    });
    begun_ = pass;
}

bool PhotonsAhead::arrived(uint32_t pass) {
    if (here_ && here_->index == pass) return true;
    if (begun_ != pass || under_way_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
    begun_.reset();
    here_.reset();  // not three passes at once
    here_ = under_way_.get();
    return true;
}

bool PhotonsAhead::wait(uint32_t pass, const CancelToken& cancel) {
    constexpr std::chrono::milliseconds kLook(20);  // for who cancels
    while (!arrived(pass)) {
        if (cancel.cancelled()) return false;
        begin(pass);
        under_way_.wait_for(kLook);
    }
    return true;
}

void PhotonsAhead::stop() {
    if (!begun_) return;
    given_up_->cancel();
    under_way_.wait();
    begun_.reset();
}

}  // namespace photond
