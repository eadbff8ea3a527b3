// How irradiance is worked out at a map's marked photons on a device: for both compilers. CPU twin:
// precomputed_irradiance.h.
#ifndef PHOTOND_PRECOMPUTED_IRRADIANCE_SHARED_H
#define PHOTOND_PRECOMPUTED_IRRADIANCE_SHARED_H

#include "renderer/photons/radiance_estimate_shared.h"

#define PRECOMPUTE_GROUP 64     // threads
#define PRECOMPUTE_PHOTONS 256  // of a group, about as many marked ones as it has threads

#define DARK_DISC_SHARE 0.25f  // of the discs in the dark: those that are asked, for all of them

#define PRECOMPUTED_IRRADIANCE_ID 55  // specialisation constant: whether there is any

#ifdef __cplusplus
namespace photond::gpu {
#endif

struct PrecomputePush {
    uint most_scatterings;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
