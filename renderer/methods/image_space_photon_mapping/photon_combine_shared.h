// From the parts of the light to the image, for both compilers.
#ifndef PHOTOND_PHOTON_COMBINE_SHARED_H
#define PHOTOND_PHOTON_COMBINE_SHARED_H

#include "renderer/gbuffer/split_shared.h"
#include "renderer/methods/image_space_photon_mapping/soft_shadows_shared.h"

// A specialisation constant: which parts a pipeline does.
#define COMBINE_PARTS_ID 84

#define COMBINE_UPSAMPLE 1u
#define COMBINE_SHADOW 2u
#define COMBINE_MERGE 4u

#ifdef __cplusplus
namespace photond::gpu {
#endif

struct BounceMapLayerPush {
    SplitRecord split;
    uint texels;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
