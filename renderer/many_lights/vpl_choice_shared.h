// Lights chosen for each point on a device, for both compilers. C++: vpl_choice.h, host side: vpl_choice_gpu.h.
#ifndef PHOTOND_VPL_CHOICE_SHARED_H
#define PHOTOND_VPL_CHOICE_SHARED_H

// Bindings beside those of vpl_lighting.comp.
#define CHOSEN_BINDING 8
#define CHOSEN_COUNTS_BINDING 9
#define VPL_TREE_BINDING 10
#define CUT_BINDING 11

// What a point's key is combined with, so that each choice has random numbers of its own: hash32(key ^ salt).
#define RESAMPLED_SALT 0x6a09e667u
#define LIGHTCUT_SALT 0xbb67ae85u

#define RESAMPLED_GROUP_LIGHTS 64u  // summed up by themselves, so that long sums stay good

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// ChosenVpl. The k-th of the i-th point of a piece is at k * VplChoicePush::stride + i.
struct ChosenVplRecord {
    uint vpl;
    float weight;
};

/// A node of a cut on its way.
struct CutNode {
    float bound;  // 0: it is not parted any further
    uint index;
};

/// Points, a thread each, half open.
struct VplChoicePush {
    uint first_point;
    uint end_point;
    uint stride;  // points there is room for
    uint most;    // lights a point asks at most
};

#ifdef __cplusplus
static_assert(sizeof(ChosenVplRecord) == 8 && sizeof(CutNode) == 8);
}  // namespace photond::gpu
#endif

#endif
