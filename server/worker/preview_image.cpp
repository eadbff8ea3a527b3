#include "server/worker/preview_image.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "renderer/error/color_map.h"
#include "renderer/film/box_downscale.h"

namespace photond {

namespace {

std::vector<uint8_t> directions(const std::vector<float>& components) {
    std::vector<uint8_t> rgb;
    rgb.reserve(components.size());
    for (const float n : components)
        rgb.push_back(static_cast<uint8_t>(std::lround(255 * std::clamp(0.5f * n + 0.5f, 0.0f, 1.0f))));
    return rgb;
}

std::vector<float> grey(const std::vector<float>& values) {
    std::vector<float> rgb;
    rgb.reserve(3 * values.size());
    for (const float value : values) rgb.insert(rgb.end(), 3, value);
    return rgb;
}

}  // namespace

PreviewImage preview_image(const Film& film, const LayerInfo* layer, float exposure_stops, ToneCurve curve,
                           uint32_t max_side) {
    const Size2 size = size_within(film.size(), max_side);
    std::vector<float> values = layer ? film.resolve(layer->layer) : film.resolve_beauty();
    if (size != film.size()) values = box_downscaled(values, layer ? layer->channel_count() : 3, film.size(), size);
    switch (layer ? layer->preview : LayerPreview::Light) {
        case LayerPreview::Light: return {size, tone_mapped(values, exposure_stops, curve)};
        case LayerPreview::HeatMap: return {size, overlap_heat_map(values)};
        case LayerPreview::Directions: return {size, directions(values)};
        case LayerPreview::Dots: return {size, tone_mapped(grey(values), exposure_stops, curve)};
        case LayerPreview::Scale: return {size, scaled_color_map(values)};
        case LayerPreview::Signed: return {size, signed_color_map(values)};
        case LayerPreview::None: break;
    }
    assert(!"the layer has a preview");
    return {};
}

}  // namespace photond
