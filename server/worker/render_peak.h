#pragma once
#include <algorithm>
#include <cstdint>

#include "server/worker/process_memory.h"

namespace photond {

/// The most physical memory while rendering: what measuring and saving take for a moment in between is left out. What
/// they keep is a structure of the memory budget.
class RenderPeak {
public:
    RenderPeak() { reset_peak_resident(); }
    uint64_t bytes() const { return std::max(before_, peak_resident_bytes()); }
    /// Around work that is not the render's.
    void pause() { before_ = bytes(); }
    void resume() { reset_peak_resident(); }

private:
    uint64_t before_ = 0;
};

}  // namespace photond
