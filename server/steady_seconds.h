#pragma once
// Seconds as a span of the steady clock.

#include <chrono>

namespace photond {

inline std::chrono::steady_clock::duration steady_seconds(double seconds) {
    return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace photond
