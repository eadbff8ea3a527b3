#include "server/service/running_attempt.h"

#include <algorithm>

#include "server/store/data_files.h"

namespace photond {

using nlohmann::json;

Snapshot::~Snapshot() { remove_quietly(path); }

void Totals::add(const RunningAttempt& attempt) {
    // One whose film could not be gone on with has begun anew, and may not have come as far again.
    const int64_t rendered = std::max<int64_t>(0, attempt.passes_done - attempt.passes_before);
    passes += rendered;
    pixels += rendered * attempt.pixels;
    render_seconds += std::max(0.0, attempt.seconds - attempt.seconds_before);
}

void Totals::add(const RunningAttempt& attempt, const json& rendered) {
    if (!rendered.is_object()) return add(attempt);
    const int64_t count = rendered.value("passes", int64_t{0});
    passes += count;
    pixels += count * attempt.pixels;
    render_seconds += rendered.value("seconds", 0.0);
    photons += rendered.value("photons", uint64_t{0});
    const json traced = rendered.value("rays", json::object());
    for (const auto& [kind, number] : traced.items()) rays[kind] += number.get<uint64_t>();
}

}  // namespace photond
