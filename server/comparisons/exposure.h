#pragma once
#include <filesystem>

namespace photond {

/// Stops that bring the image's log-average luminance to 0.18, to a quarter of a stop, within ±16
/// [Reinhard et al. 2002] Photographic Tone Reproduction for Digital Images, Eq. 1 and 2 (its key). Pixels that are
/// black or not finite are left out; 0 when none is left.
/// `raw`: a file of scene-linear RGB as 32-bit floats, little-endian, as the helper writes pixels.
double exposure_stops(const std::filesystem::path& raw);

}  // namespace photond
