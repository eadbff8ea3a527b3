#pragma once
// How a display shows a layer: what previews of a job can be asked for.

#include "renderer/film/layers.h"

namespace photond {

enum class LayerPreview : uint8_t {
    None,
    Light,       // by exposure and tone curve, as the beauty
    HeatMap,     // splats over a pixel: blue 0, green 200, red 400, white 600
    Directions,  // (n + 1) / 2 as display values
    Dots,        // what a pass puts on a pixel, as grey light: 1 is white
};

constexpr LayerPreview preview_of(const LayerInfo& info) {
    if (info.radiance() || info.layer == Layer::Voxels || info.layer == Layer::SplitIndirect)
        return LayerPreview::Light;
    if (info.layer == Layer::Overlap) return LayerPreview::HeatMap;
    if (info.layer == Layer::SplitNormal) return LayerPreview::Directions;
    return info.layer == Layer::Vpls ? LayerPreview::Dots : LayerPreview::None;
}
/// Whether exposure and tone curve mean anything to it.
constexpr bool has_exposure(LayerPreview preview) {
    return preview == LayerPreview::Light || preview == LayerPreview::Dots;
}

}  // namespace photond
