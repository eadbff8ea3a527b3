// What the shaders of a second pass that gathers are told: for both compilers.
#ifndef PHOTOND_GATHERING_SHARED_H
#define PHOTOND_GATHERING_SHARED_H

#include "renderer/photons/precomputed_irradiance_shared.h"
#include "renderer/photons/radiance_estimate_shared.h"

#define SPLIT_SAMPLERS_GROUP 64  // threads
#define SPLIT_PREPARED_SETS 18   // sample_set() of the first four vertices is below

// Specialisation constants.
#define FINAL_GATHER_ID 44
#define GLOBAL_MAP_ID 45  // whether there is one
#define CAUSTIC_MAP_ID 46
#define GATHER_LANES_ID 47  // threads of a point that gathers

#ifdef __cplusplus
namespace photond::gpu {
using uvec4 = glm::uvec4;
#endif

struct GatheringConstants {
    EstimateConstants estimate;
    float glossy_threshold;
    uint light_samples;           // of a vertex, at most
    uint gather_rays;             // the same
    uint lights_can_be_met;       // by rays: area lights or an environment
    uint irradiance_scatterings;  // of the photons that the precomputed irradiance is of
};

struct EyePassPush {
    uint first_tile;
    uint end_tile;
    uint capacity;  // gather points there is room for; what comes after is counted alone
};

/// A point the eye sees whose rough part gathers light: where it is, so that its surface can be made again.
struct GatherPointRecord {
    vec3 throughput;  // of the path up to here
    float eta_scale;
    vec3 ray_direction;  // of the ray that met the surface
    float outside_ior;
    uint instance;
    uint triangle;
    float u;
    float v;
    uvec4 media;
    uint scatterings;  // of the path before this point
    uint key;          // names its numbers
    uint rays;
    uint light_samples;  // drawn there
    uint next;           // the point before it on the same pixel's path; NO_POINT: none
};
#define NO_POINT 0xffffffffu

/// What one of a point's threads gathered: sums over its rays.
struct GatheredRecord {
    vec3 direct;
    vec3 indirect;
    uint photons;
};

struct GatherPush {
    uint capacity;  // points there is room for
};

struct GatherSumPush {
    uint first_tile;
    uint end_tile;
};

// Words of the points' state.
#define POINTS_WORD 0       // of the piece, those without room included
#define MOST_POINTS_WORD 1  // of a piece of the pass
#define POINT_STATE_WORDS 2

#define GATHER_GROUP 64  // threads

struct SplitSamplersPush {
    uint light_samples;
    uint gather_rays;
};

#ifdef __cplusplus
static_assert(sizeof(GatheringConstants) == sizeof(EstimateConstants) + 20 && sizeof(GatherPointRecord) == 84 &&
              sizeof(GatheredRecord) == 28);
}  // namespace photond::gpu
#endif

#endif
