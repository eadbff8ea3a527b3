// What sub-paths carry for their weights, for both compilers. CPU twin: mis_weights.h.
#ifndef PHOTOND_MIS_WEIGHTS_SHARED_H
#define PHOTOND_MIS_WEIGHTS_SHARED_H

#define MIS_POWER_ID 58  // specialisation constant: the heuristic is MisHeuristic::Power

#ifdef __cplusplus
#include <cstdint>

namespace photond::gpu {
using uint = uint32_t;
#endif

/// As photond::TechniqueNumbers.
struct TechniqueNumbers {
    float light_paths;
    float connections;
    uint merges;  // 0 or 1
    float caustic_radius;
};

/// As photond::SubpathWeights.
struct SubpathWeights {
    float last;
    float ends;
    float connections;
    float merges;
    float newest_merge;
};

#ifdef __cplusplus
static_assert(sizeof(TechniqueNumbers) == 16 && sizeof(SubpathWeights) == 20);
}  // namespace photond::gpu
#endif

#endif
