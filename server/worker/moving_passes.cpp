#include "server/worker/moving_passes.h"

#include <cmath>

#include "renderer/core/rng.h"

namespace photond {

double shutter_share(uint64_t seed, uint32_t pass) {
    constexpr double kGoldenRatio = 0.6180339887498949;
    const double start = static_cast<double>(hash64(seed) >> 11) * 0x1p-53;
    const double at = start + static_cast<double>(pass) * kGoldenRatio;
    return at - std::floor(at);
}

void MovingPasses::begin(const RenderContext&, Stats&) {}

void MovingPasses::run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) {
    method_ = nullptr;  // before what it borrows changes
    context_.reset();
    context_.emplace(job_.show(job_.open_s + job_.shutter_s * shutter_share(job_.seed, pass), stats));
    method_ = job_.make();
    method_->begin(*context_, stats);
    method_->run_pass(pass, stats, cancel);
}

}  // namespace photond
