// What photon_tracing.comp is told, and what it counts: for both compilers.
#ifndef PHOTOND_PHOTON_TRACING_SHARED_H
#define PHOTOND_PHOTON_TRACING_SHARED_H

#include "renderer/transport/sobol_shared.h"

#define PHOTON_TRACING_GROUP 64  // threads

#define BOUNCE_MAP_ID 89  // specialisation constant: whether photons leave from FirstHits

#ifdef __cplusplus
namespace photond::gpu {
#endif

/// Where light first arrives, and what arrives there: a texel of the bounce map.
struct FirstHit {
    vec3 ray_direction;
    float t;  // the hit; its instance is ~0 where the light goes by everything
    uint instance;
    uint triangle;
    float u;
    float v;
    vec3 power_w;    // of all photons, at emission; 0: there is none
    float arriving;  // share of that which arrives
};

struct BounceMapPush {
    SequenceKey sequence;
    uint64_t first_element;  // of the sequence: that of the pass's texel 0
    uint first_texel;        // half open
    uint end_texel;
};

struct PhotonTracingPush {
    SequenceKey sequence;
    uint64_t first_element;  // of the sequence: that of the pass's path 0
    uint first_path;         // of the paths traced here, half open
    uint end_path;
    uint photons;  // paths of a pass, which share the power
    uint most_scatterings;
    uint kind;      // PHOTON_MAP_...
    uint capacity;  // photons there is room for; what comes after is counted alone
    float glossy_threshold;
    uint threads;
    uint texels;  // of the bounce map, if there is one
};

/// Words of the tracer's state.
#define PHOTONS_STORED_WORD 0  // of the pass, those without room included
#define NEXT_PATH_WORD 1       // of a dispatch: paths that a thread took after its first
#define PHOTON_RAYS_WORD 2     // of the pass: 64 bits, low first
#define NAN_SAMPLES_WORD 4
#define INFINITE_SAMPLES_WORD 5
#define PHOTON_STATE_WORDS 6

#ifdef __cplusplus
static_assert(sizeof(PhotonTracingPush) == 64 && sizeof(FirstHit) == 48);
}  // namespace photond::gpu
#endif

#endif
