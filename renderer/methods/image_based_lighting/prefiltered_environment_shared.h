// The environment blurred by roughness, for both compilers.
#ifndef PHOTOND_PREFILTERED_ENVIRONMENT_SHARED_H
#define PHOTOND_PREFILTERED_ENVIRONMENT_SHARED_H

#define PREFILTER_MOST_LEVELS 24
#define PREFILTER_LEAST_SIDE 64  // cells: even where a small light sets, irradiance is linear within them to 2 %

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// An octahedral map: (side + 1)^2 nodes, row by row. Nodes lie on the border, so that no lookup reaches across it.
struct PrefilterLevel {
    uint first;
    uint side;
};

struct PrefilterConstants {
    uint levels;
    float least_roughness;  // of the first level; the last one's is 1
    PrefilterLevel level[PREFILTER_MOST_LEVELS];
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
