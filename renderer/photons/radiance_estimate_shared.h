// Photon maps on the device and how they are looked up: for both compilers. CPU twins: photon_map.h,
// radiance_estimate.h.
#ifndef PHOTOND_RADIANCE_ESTIMATE_SHARED_H
#define PHOTOND_RADIANCE_ESTIMATE_SHARED_H

#include "renderer/photons/disc_coverage_shared.h"
#include "renderer/photons/hash_grid_shared.h"
#include "renderer/photons/kernel_shared.h"
#include "renderer/photons/photon_shared.h"

#define NEAREST_BUCKETS 32  // of the squared distances' histogram
#define NEAREST_AT_ONCE 8   // candidates among which the k-th is found directly

// Specialisation constants.
#define SEARCH_NEAREST_ID 42  // PhotonSearch::Kind
#define SOFT_DISC_ID 43
#define DISC_MOMENTS_ID 56

#define DISC_SECTORS 8  // DiscMoments::kSectors

#ifdef __cplusplus
namespace photond::gpu {
#endif

struct PhotonMapConstants {
    HashGridConstants grid;
    float radius_m;  // of the search; of the nearest: the farthest that is looked at
    uint nearest;    // k
};

/// What estimates by any of a pass's maps share; the indices of `maps` are the constants PHOTON_MAP_*.
struct EstimateConstants {
    PhotonMapConstants maps[2];
    KernelRecord kernel;
    float disc_thickness_m;  // negative: a quarter of the disc's radius
    DiscCoverageConstants coverage;
    uint first_irradiance;  // where precomputed ones stand behind the powers, one for each of the global map's photons
};

#ifdef __cplusplus
static_assert(sizeof(EstimateConstants) == 2 * 68 + 16 + sizeof(DiscCoverageConstants) + 4);
}  // namespace photond::gpu
#endif

#endif
