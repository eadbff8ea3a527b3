// What photon_tracing.comp is told, and what it counts: for both compilers.
#ifndef PHOTOND_PHOTON_TRACING_SHARED_H
#define PHOTOND_PHOTON_TRACING_SHARED_H

#include "renderer/transport/sobol_shared.h"

#define PHOTON_TRACING_GROUP 64  // threads

#ifdef __cplusplus
namespace photond::gpu {
#endif

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
};

/// Words of the tracer's state.
#define PHOTONS_STORED_WORD 0  // of the pass, those without room included
#define NEXT_PATH_WORD 1       // of a dispatch: paths that a thread took after its first
#define PHOTON_RAYS_WORD 2     // of the pass: 64 bits, low first
#define NAN_SAMPLES_WORD 4
#define INFINITE_SAMPLES_WORD 5
#define PHOTON_STATE_WORDS 6

#ifdef __cplusplus
static_assert(sizeof(PhotonTracingPush) == 56);
}  // namespace photond::gpu
#endif

#endif
