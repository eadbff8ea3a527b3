#pragma once
// The layers that GPU tests ask of each method. The driver compiles a pipeline for each set of layers, so the unit
// tests and the statistical tests of a method share one set and one compilation.

#include <initializer_list>

#include "renderer/film/layers.h"

namespace photond::test {

inline LayerSet layer_set(std::initializer_list<Layer> layers) {
    LayerSet set;
    for (const Layer layer : layers) set.add(layer);
    return set;
}

inline LayerSet path_tracing_layers() {
    return layer_set(
        {Layer::Caustic, Layer::Albedo, Layer::Normal, Layer::Position, Layer::Depth, Layer::GeometricNormal});
}
inline LayerSet photon_mapping_layers() {
    return layer_set({Layer::Caustic, Layer::Albedo, Layer::Normal, Layer::Position, Layer::Depth, Layer::PhotonCount});
}
inline LayerSet photon_splatting_layers() {
    return layer_set({Layer::Albedo, Layer::Normal, Layer::Depth, Layer::Overlap});
}
inline LayerSet progressive_layers() {
    return layer_set({Layer::Caustic, Layer::PhotonCount, Layer::Radius, Layer::BiasEstimate});
}
inline LayerSet bidirectional_layers() {
    return layer_set({Layer::Caustic, Layer::Connections, Layer::Merges, Layer::LightImage});
}

}  // namespace photond::test
