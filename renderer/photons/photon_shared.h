// Photons as shaders see them: for both compilers. CPU twin: photon.h.
#ifndef PHOTOND_PHOTON_SHARED_H
#define PHOTOND_PHOTON_SHARED_H

#define PHOTON_MAP_GLOBAL 0  // PhotonMapKind
#define PHOTON_MAP_CAUSTIC 1
#define PHOTON_MOST_SCATTERINGS 255u  // PhotonPayload::kMostScatterings
#define PHOTON_NORMAL_BITS 0x3fffffu  // of PhotonPayload::normal_and_path
#define PHOTONS_A_MARK 4u             // of which one is marked: Christensen found no difference to be seen

// What of a path's sets of numbers its emission uses: sample_set(EmissionSet) of photon_tracing_scene.h.
#define PHOTON_SET_DIRECTION 0u
#define PHOTON_SET_POSITION 1u
#define PHOTON_SET_LIGHT 3u

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// Half of a photon: what the tests of a disc need, 16 bytes to be loaded at once.
struct PhotonPlace {
    vec3 position;
    uint normal_and_path;  // PhotonPayload's
};
/// The other half: what a photon that passed them brings.
struct PhotonPower {
    vec3 power_w;
    uint direction;  // PhotonPayload's
};

#ifdef __cplusplus
static_assert(sizeof(PhotonPlace) == 16 && sizeof(PhotonPower) == 16);
}  // namespace photond::gpu
#endif

#endif
