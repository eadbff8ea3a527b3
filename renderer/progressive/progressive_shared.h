// What progressive_mapping.comp is told: for both compilers.
#ifndef PHOTOND_PROGRESSIVE_SHARED_H
#define PHOTOND_PROGRESSIVE_SHARED_H

#include "renderer/photons/radiance_estimate_shared.h"
#include "renderer/progressive/point_radii_shared.h"
#include "renderer/progressive/radius_map_shared.h"

// A specialisation constant.
#define RADIUS_RULE_ID 57  // RADIUS_RULE_*

#define RADIUS_RULE_GLOBAL 0  // RadiusRule; `tested` by its tests
#define RADIUS_RULE_TRAINED 1
#define RADIUS_RULE_LOCAL 2
#define RADIUS_RULE_RADIAL 3
#define RADIUS_RULE_SECTOR 4

#ifdef __cplusplus
namespace photond::gpu {
#endif

/// What the radii of one map go by, beside EstimateConstants::maps[kind].radius_m: that of the pass, by the rule
/// `global`.
struct MapRadiiConstants {
    PhotonMapConstants pilot;  // rules of points: its k-th photon says the first radius
    uint first_node;           // rule `trained`: in the records of both maps
    uint first_leaf;
    uint first_word;  // rules of points: of the map's records
};

struct ProgressiveConstants {
    EstimateConstants estimate;
    MapRadiiConstants radii[2];  // by PHOTON_MAP_*
    float share;                 // rule `trained`: of the radii, by the pass
    float first_radius_m;        // rules of points: where it is given; 0: by the pilot
    float least_radius_m;        // and by the pilot it is within these
    float most_radius_m;
    float alpha;
    float bias_factor;  // of the kernel, over the constant one's
    float glossy_threshold;
};

struct ProgressivePush {
    uint first_tile;
    uint end_tile;
};

#ifdef __cplusplus
static_assert(sizeof(ProgressiveConstants) == sizeof(EstimateConstants) + 2 * sizeof(MapRadiiConstants) + 28 &&
              sizeof(MapRadiiConstants) == sizeof(PhotonMapConstants) + 12);
}  // namespace photond::gpu
#endif

#endif
