// Which voxels of proxies points of the image see, for both compilers (visibility_lists_gpu.h).
#ifndef PHOTOND_VISIBILITY_LISTS_SHARED_H
#define PHOTOND_VISIBILITY_LISTS_SHARED_H

#include "renderer/gbuffer/split_shared.h"
#include "renderer/methods/visibility_filtering/kept_lists_shared.h"
#include "renderer/photons/hash_grid_shared.h"

#define LISTS_GROUP 64  // threads

// Specialisation constants.
#define PROXY_VISIBILITY_ID 91
#define PROXY_VISIBILITY_DISCS 0u  // ProxyVisibility
#define PROXY_VISIBILITY_SVO 1u
#define PROXY_VISIBILITY_RAYS 2u
#define WORLD_RAYS_ID 92
#define LISTS_ID 94
#define LISTS_COUNTS 0u  // ListKind
#define LISTS_BITS 1u
#define LISTS_INDICES 2u
#define LISTS_NONE 3u  // shadow rays tell instead
#define PAPER_NORMALISATION_ID 93
#define PAPER_SPECULAR_ID 99

#define FILTER_MOST_WORDS 2048  // of LISTS_INDICES, before the filter
#define FILTER_MOST_SIDE 7      // lists: a thread of a group looks at one of the square

#ifdef __cplusplus
namespace photond::gpu {
#endif

/// Of a pass.
struct VisibilityConstants {
    HashGridConstants grid;  // its cells are the voxels
    SplitRecord split;
    uint march_side;     // pixels along the blocks of which one has a list
    uint march_columns;  // lists
    uint march_rows;
    uint words;       // of a list before the filter, and of all lit voxels
    uint list_words;  // of a list after it
    uint rays;        // of a list
    uint filter_side;
    float filter_normal;    // least cosine between the normals of points that share what they see
    float filter_distance;  // greatest distance from each other's planes, over the depth
    float disc_radius_m;
    float near_m;           // up to there a voxel's proxies count one by one
    float most_seen;        // of a voxel: 1, or more where few rays meet it
    float softening_sq_m2;  // of their falloff
    float proxies_per_m2;
    float glossy_threshold;
    float world_cell_m;  // of places that share their rays
    uint key;            // of the pass's random numbers
    uint world_key;      // of the directions of rays that are tied to the world, whatever the seed
    KeptConstants kept;
};

struct ListsPush {
    uint first;  // half open
    uint end;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
