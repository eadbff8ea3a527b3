// What the shaders of photon mapping's second pass are told: for both compilers.
#ifndef PHOTOND_PHOTON_MAPPING_SHARED_H
#define PHOTOND_PHOTON_MAPPING_SHARED_H

#include "renderer/photons/radiance_estimate_shared.h"

#define SPLIT_SAMPLERS_GROUP 64  // threads
#define SPLIT_PREPARED_SETS 18   // sample_set() of the first four vertices is below

// Specialisation constants.
#define FINAL_GATHER_ID 44
#define GLOBAL_MAP_ID 45  // whether there is one
#define CAUSTIC_MAP_ID 46

#ifdef __cplusplus
namespace photond::gpu {
#endif

struct PhotonMappingConstants {
    EstimateConstants estimate;
    float glossy_threshold;
    uint light_samples;      // of a vertex, at most
    uint gather_rays;        // the same
    uint lights_can_be_met;  // by rays: area lights or an environment
};

struct PhotonMappingPush {
    uint first_tile;
    uint end_tile;
};

struct SplitSamplersPush {
    uint light_samples;
    uint gather_rays;
};

#ifdef __cplusplus
static_assert(sizeof(PhotonMappingConstants) == sizeof(EstimateConstants) + 16);
}  // namespace photond::gpu
#endif

#endif
