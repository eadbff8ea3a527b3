#pragma once
#include <vector>

#include "renderer/film/film.h"
#include "renderer/film/tone_curve.h"

namespace photond {

/// 8-bit sRGB, interleaved, as on a display.
struct PreviewImage {
    Size2 size;
    std::vector<uint8_t> rgb;
};

/// Of the beauty, or of a layer that the film has and that has a preview (null: the beauty). Exposure and curve are
/// used where has_exposure() says so. A film whose longer side is more than `max_side` is scaled down to it, by means
/// over pixels of its values, before they are made colours.
PreviewImage preview_image(const Film& film, const LayerInfo* layer, float exposure_stops, ToneCurve curve,
                           uint32_t max_side = UINT32_MAX);

}  // namespace photond
