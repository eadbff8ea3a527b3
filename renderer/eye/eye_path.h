#pragma once
// One path from the eye between two of its vertices.

#include "renderer/transport/medium_stack.h"

namespace photond {

struct EyePath {
    Rgb throughput{1};
    float pdf_sa = 0;     // with which the ray's direction was drawn, over the number of light samples beside it
    vec3 position{0};     // of the last vertex; with lit_normal as given to the light sampler
    float eta_scale = 1;  // squared index of the medium the ray is in, which throughput is divided by
    vec3 lit_normal{0};
    uint32_t pixel = 0;
    uint32_t scatterings = 0;  // from the first non-delta vertex x_1 on (conventions.md)
    bool delta = true;         // the last scattering was a delta lobe's, or there was none: no light sample competes
    bool caustic = true;       // all scatterings after x_1 were delta
    MediumStack media;
};

}  // namespace photond
