#pragma once
// What the rows of the bidirectional methods have in common. Only a room's row.cpp needs this.

#include "renderer/bidirectional/bidirectional_params.h"
#include "renderer/frame/method_row.h"

namespace photond {

/// `Gpu`: void where there is none.
template <class Cpu, class Gpu>
MethodInfo bidirectional_row() {
    MethodInfo info = row_of_classes<Cpu, Gpu>();
    info.family = "bidirectional";
    info.layers.add(Layer::Connections);
    info.layers.add(Layer::LightImage);
    info.layers.add(Layer::Techniques);
    return info;
}

}  // namespace photond
