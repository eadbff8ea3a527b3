// Photons scattered over the pixels they light, for both compilers.
#ifndef PHOTOND_PHOTON_SCATTER_SHARED_H
#define PHOTOND_PHOTON_SCATTER_SHARED_H

#include "renderer/gbuffer/split_shared.h"
#include "renderer/photons/disc_coverage_shared.h"
#include "renderer/photons/hash_grid_shared.h"
#include "renderer/photons/kernel_shared.h"

#define SCATTER_GROUP 64      // threads: those of a block of pixels, and of a batch of photons
#define SCATTER_BLOCK_SIDE 8  // pixels

// Specialisation constants.
#define FOOTPRINT_VOLUME_ID 81  // PhotonFootprint::Volume
#define UPSAMPLING_ID 82

#define UPSAMPLING_NEAREST 0u  // Upsampling
#define UPSAMPLING_BILINEAR 1u
#define UPSAMPLING_NORMAL 2u
#define UPSAMPLING_GEOMETRY 3u
#define UPSAMPLING_LEAST 0.05f  // of the weights about a pixel: below it, it is lit itself

// Half the height of a footprint over its radius.
#define QUAD_HEIGHT 0.25f
#define VOLUME_HEIGHT 0.5f

#ifdef __cplusplus
namespace photond::gpu {
#endif

/// Of a pass.
struct PhotonScatterConstants {
    HashGridConstants maps[2];  // PhotonMapKind
    float radius_m;             // of the footprints
    uint first_batch[2];        // of a map's, among the batches of both
    KernelRecord kernel;
    SplitRecord split;
    DiscCoverageConstants coverage;
    uint turn;  // a random number, for the coverage of footprints
    float glossy_threshold;
};

/// What bounds the photons of a batch; none: `low` is greater than `high`.
struct PhotonBatch {
    vec3 low;
    vec3 high;
};

struct PhotonBatchPush {
    uint map;
    uint batches;
};

struct PhotonScatterPush {
    uint first_block;  // half open
    uint end_block;
    uint map;
    uint batches;
};

#ifdef __cplusplus
static_assert(sizeof(PhotonScatterConstants) == 2 * 60 + 12 + 12 + 24 + sizeof(DiscCoverageConstants) + 8 &&
              sizeof(PhotonBatch) == 24);
}  // namespace photond::gpu
#endif

#endif
