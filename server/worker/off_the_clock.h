#pragma once
#include "renderer/core/stats.h"
#include "server/worker/render_peak.h"

namespace photond {

/// A stage that is not the render's: neither its time nor the memory it takes for a moment count as such.
class OffTheClock {
public:
    OffTheClock(Stats& stats, std::string_view stage, RenderPeak& peak) : peak_(peak), timer_(stats, stage) {
        peak_.pause();
    }
    ~OffTheClock() { peak_.resume(); }
    OffTheClock(const OffTheClock&) = delete;
    OffTheClock& operator=(const OffTheClock&) = delete;

private:
    RenderPeak& peak_;
    const StageTimer timer_;
};

inline constexpr std::string_view kErrorMeasuringStage = "error_measuring";
inline constexpr std::string_view kFilmSavingStage = "film_saving";
inline constexpr std::string_view kReferenceLoadStage = "reference_load";

}  // namespace photond
