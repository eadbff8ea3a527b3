#include "renderer/backends/gpu/counters.h"

namespace photond::gpu {

void Counters::record_readback(CommandList& commands) {
    commands.copy(counters_, 0, host_, 0, kBytes);
    commands.host_reads(host_);
}

void Counters::read(Counts& counts) const {
    const auto* words = reinterpret_cast<const uint32_t*>(host_.mapped());
    const auto counted = [&](uint32_t counter) { return uint64_t{words[2 * counter + 1]} << 32 | words[2 * counter]; };
    counts.camera_rays += counted(COUNTER_CAMERA_RAYS);
    counts.bounce_rays += counted(COUNTER_BOUNCE_RAYS);
    counts.shadow_rays += counted(COUNTER_SHADOW_RAYS);
    counts.photon_rays += counted(COUNTER_PHOTON_RAYS);
    counts.photons_emitted += counted(COUNTER_PHOTONS_EMITTED);
    counts.photons_stored += counted(COUNTER_PHOTONS_STORED);
    counts.splats += counted(COUNTER_SPLATS);
    counts.splat_contributions += counted(COUNTER_SPLAT_CONTRIBUTIONS);
}

}  // namespace photond::gpu
