// The radiance cache on a device, for both compilers (radiance_cells_gpu.h).
#ifndef PHOTOND_RADIANCE_CACHE_SHARED_H
#define PHOTOND_RADIANCE_CACHE_SHARED_H

#define CACHE_GROUP 64  // threads

#define CACHE_SLOTS 8u         // RadianceCells::kSlots
#define CACHE_MOST_AGE 4u      // RadianceCells::kMostAge
#define CACHE_FINER_LEVELS 3u  // CellGrid's
#define CACHE_COARSER_LEVELS 3u
#define CACHE_MOST_LEVEL 20u
#define CACHE_MOST_RECORDS 8u             // CachedPaths::kMostRecords
#define CACHE_UNITS_OF_MOST 4294967296.0  // of the brightest of the first samples
#define CACHE_MOST_UNITS 1.0e12

// A cell's sums: three of two words, the lower first, then its samples and the last round that it had one in.
#define CACHE_SUM_WORDS 8u
#define CACHE_SAMPLES_WORD 6u
#define CACHE_ROUND_WORD 7u

// Words of the state; counts have two, the lower first.
#define CACHE_BRIGHTEST 0  // the bits of the brightest channel of the samples of the first round that was not black
#define CACHE_FOUND 1      // of all rounds so far
#define CACHE_REFUSED 2
#define CACHE_HITS 4
#define CACHE_MISSES 6
#define CACHE_STATE_WORDS 8

#ifdef __cplusplus
#include "renderer/core/geometry.h"

namespace photond::gpu {
using uint = uint32_t;
#endif

/// CellGrid, and what paths are told of the cells.
struct CacheConstants {
    vec3 eye;
    float coarsest_m;
    vec3 origin;
    float of_distance;
    uint buckets;
    uint least_samples;
    uint direction_bins;
    float glossy_threshold;
    uint bounces_are_limited;  // 0 or 1
    uint key;                  // of the cells' own numbers
};

/// A vertex of a path that fills the cache, which leaves a sample. What its cell gets is own_rough + through_rough
/// times what arrives along the path's next ray: `arrives`, and `link` times what the next such vertex sends, own +
/// weight times what arrives there.
struct CacheRecord {
    vec3 position;
    uint normal;               // Octahedral<16>
    uint level_and_direction;  // the level in the five lowest bits
    float spread_m;
    uint random;
    vec3 inverse_albedo;
    vec3 own_rough;  // at last, the sample
    vec3 own;
    vec3 through_rough;
    vec3 weight;
    vec3 arrives;
    vec3 link;
};

/// Of cache_train.comp.
struct CacheTrainPush {
    uint first_tile;  // among the tiles in their order, half open
    uint end_tile;
    uint ends_in_cells;  // 0 or 1
};

/// Of cache_room.comp, cache_insert.comp and cache_add.comp.
struct CacheRoundPush {
    uint paths;
    uint round;
};

/// Of cache_gather.comp.
struct CacheGatherPush {
    uint first_tile;
    uint end_tile;
    uint asks_cells;   // 0 or 1
    uint shows_cells;  // 0 or 1
    float share;       // of the path in its pixel
};

#ifdef __cplusplus
static_assert(sizeof(CacheConstants) == 56 && sizeof(CacheRecord) == 112, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
