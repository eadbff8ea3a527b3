// Lamps (lamps.h), for both compilers.
#ifndef PHOTOND_LAMPS_SHARED_H
#define PHOTOND_LAMPS_SHARED_H

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
#endif

/// Mean and covariance of the places that a lamp's light comes from.
struct LampShape {
    vec3 centre;         // world [m]
    vec3 variance_m2;    // xx, yy, zz
    vec3 covariance_m2;  // yz, zx, xy
};

// Words that tell which lamp a light is: the number of the first punctual light's, the others follow; then by emitter
// (light_tables_shared.h).
#define LAMP_FIRST_PUNCTUAL 0
#define LAMP_OF_EMITTERS 1

#ifdef __cplusplus
static_assert(sizeof(LampShape) == 36);
}  // namespace photond::gpu
#endif

#endif
