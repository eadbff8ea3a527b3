#pragma once
#include <vector>

#include "renderer/film/film.h"
#include "renderer/film/layer_preview.h"
#include "renderer/film/tone_curve.h"

namespace photond {

/// 8-bit sRGB, interleaved, of a layer that the film has and that has a preview. Exposure and curve are used where
/// has_exposure() says so.
std::vector<uint8_t> preview_image(const Film& film, const LayerInfo& layer, float exposure_stops, ToneCurve curve);

}  // namespace photond
