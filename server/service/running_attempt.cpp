#include "server/service/running_attempt.h"

#include <algorithm>

#include "server/store/data_files.h"

namespace photond {

Snapshot::~Snapshot() { remove_quietly(path); }

void Totals::add(const RunningAttempt& attempt) {
    // One whose film could not be gone on with has begun anew, and may not have come as far again.
    const int64_t rendered = std::max<int64_t>(0, attempt.passes_done - attempt.passes_before);
    passes += rendered;
    pixels += rendered * attempt.pixels;
    render_seconds += std::max(0.0, attempt.seconds - attempt.seconds_before);
}

void Totals::add(const RunningAttempt& attempt, const std::optional<RenderedWork>& rendered) {
    if (!rendered) return add(attempt);
    passes += rendered->passes;
    pixels += rendered->passes * attempt.pixels;
    render_seconds += rendered->seconds;
    photons += rendered->photons;
    rays["camera"] += rendered->rays.camera;
    rays["bounce"] += rendered->rays.bounce;
    rays["shadow"] += rendered->rays.shadow;
    rays["photon"] += rendered->rays.photon;
}

}  // namespace photond
