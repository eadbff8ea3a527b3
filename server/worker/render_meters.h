#pragma once
#include "server/worker/core_share.h"
#include "server/worker/render_peak.h"

namespace photond {

/// What is measured of a render beside its clock. What is off the clock is not the render's here either.
struct RenderMeters {
    RenderPeak peak;
    CoreShare cores;

    void pause() { peak.pause(), cores.pause(); }
    void resume() { peak.resume(), cores.resume(); }
};

}  // namespace photond
