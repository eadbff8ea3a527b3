#pragma once
#include "renderer/core/stats.h"
#include "server/worker/render_meters.h"

namespace photond {

/// A stage that is not the render's: neither its time nor the memory it takes for a moment count as such, nor the
/// processors that it has or lacks.
class OffTheClock {
public:
    OffTheClock(Stats& stats, std::string_view stage, RenderMeters& meters) : meters_(meters), timer_(stats, stage) {
        meters_.pause();
    }
    ~OffTheClock() { meters_.resume(); }
    OffTheClock(const OffTheClock&) = delete;
    OffTheClock& operator=(const OffTheClock&) = delete;

private:
    RenderMeters& meters_;
    const StageTimer timer_;
};

inline constexpr std::string_view kErrorMeasuringStage = "error_measuring";
inline constexpr std::string_view kFilmSavingStage = "film_saving";
inline constexpr std::string_view kReferenceLoadStage = "reference_load";

}  // namespace photond
