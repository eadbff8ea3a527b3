// Where proxies are put, for both compilers.
#ifndef PHOTOND_PROXY_PLACEMENT_SHARED_H
#define PHOTOND_PROXY_PLACEMENT_SHARED_H

#include "renderer/methods/visibility_filtering/point_proxies_shared.h"

#ifdef __cplusplus
namespace photond::gpu {
#endif

/// Of proxy_counts.comp and proxy_places.comp.
struct ProxyPush {
    uint64_t seed;
    uint pass;
    uint instances;
    uint capacity;  // proxies there is room for
    uint first_proxy;
    float per_m2;
    float glossy_threshold;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
