// Soft shadows from those of the lights' middles, for both compilers.
#ifndef PHOTOND_SOFT_SHADOWS_SHARED_H
#define PHOTOND_SOFT_SHADOWS_SHARED_H

#define SOFT_SHADOW_ID 83  // specialisation constant

#define SOFT_SHADOW_GATHER 0u  // SoftShadow
#define SOFT_SHADOW_FIXED_RADIUS 1u
#define SOFT_SHADOW_RAYS 2u
#define SOFT_SHADOW_NONE 3u

#ifdef __cplusplus
namespace photond::gpu {
using uint = uint32_t;
#endif

/// Pixels that are asked, along either side of a square that is laid over a disc.
struct ShadowSamples {
    uint search;
    uint blur;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
