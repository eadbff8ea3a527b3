// Photons scattered over the pixels they light, for both compilers.
#ifndef PHOTOND_PHOTON_SCATTER_SHARED_H
#define PHOTOND_PHOTON_SCATTER_SHARED_H

#include "renderer/gbuffer/split_shared.h"
#include "renderer/photons/disc_coverage_shared.h"
#include "renderer/photons/hash_grid_shared.h"
#include "renderer/photons/kernel_shared.h"
#include "renderer/scene/camera_shared.h"

#define SCATTER_GROUP 64      // threads: those of a block of pixels, and of a batch of photons
#define SCATTER_BLOCK_SIDE 8  // pixels

// Specialisation constants.
#define FOOTPRINT_ID 81
#define SCATTER_DRAWS_ID 88  // whether photons are drawn over the pixels that can be found so

#define FOOTPRINT_QUAD 0u  // PhotonFootprint
#define FOOTPRINT_VOLUME 1u
#define FOOTPRINT_AUTO 2u

#define QUAD_HEIGHT 0.25f  // half the height of a quad over its radius

#ifdef __cplusplus
#include "renderer/core/stats.h"

namespace photond::gpu {
#endif

/// Of a pass.
struct PhotonScatterConstants {
    HashGridConstants maps[2];  // PhotonMapKind
    float radius_m;             // of the largest footprints
    float radius_of_map_m[2];   // of a map's
    float volume_height;        // half the height of a volume over its radius
    uint first_batch[2];        // of a map's, among the batches of both
    KernelRecord kernel;
    SplitRecord split;
    DiscCoverageConstants coverage;
    uint turn;  // a random number, for the coverage of footprints
    float glossy_threshold;
    float filter_reach;  // of the pixel filter, along an axis [pixels]
    CameraConstants camera;
};

/// What bounds the photons of a batch; none: `low` is greater than `high`.
struct PhotonBatch {
    vec3 low;
    vec3 high;
};

#define PHOTON_BOUNCES 8  // Counts::kBounces

struct PhotonBatchPush {
    uint map;
    uint batches;
};

/// Photons of a map that are drawn.
struct PhotonRasterPush {
    uint map;
    uint first_photon;
};

struct PhotonScatterPush {
    uint first_block;  // half open
    uint end_block;
    uint map;
    uint batches;
};

#ifdef __cplusplus
static_assert(PHOTON_BOUNCES == Counts::kBounces);
static_assert(sizeof(PhotonScatterConstants) ==
                  2 * 60 + 24 + 12 + 24 + sizeof(DiscCoverageConstants) + 12 + sizeof(CameraConstants) &&
              sizeof(PhotonBatch) == 24);
}  // namespace photond::gpu
#endif

#endif
