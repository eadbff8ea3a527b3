// Point proxies and the voxels they lie in, for both compilers (point_proxies_gpu.h).
#ifndef PHOTOND_POINT_PROXIES_SHARED_H
#define PHOTOND_POINT_PROXIES_SHARED_H

#define PROXY_GROUP 64  // threads
// A proxy's word beside its place: its normal on the side that light reaches, and whether any does.
#define PROXY_NORMAL_BITS 15u  // along either axis of the octahedron
#define PROXY_LIT 0x40000000u
#define NO_PROXY 0xffffffffu  // the surface has a hole there

// Words of the proxies' state.
#define PROXIES_WORD 0          // that there are
#define PROXY_TRIANGLES_WORD 1  // of all instances
#define PROXY_NAN_WORD 2        // of them without light, as it was no number
#define PROXY_STATE_WORDS 3

#include "renderer/photons/hash_grid_shared.h"

#ifdef __cplusplus
namespace photond::gpu {
using uint = uint32_t;
#endif

/// Of proxy_voxels.comp.
struct ProxyVoxelsPush {
    HashGridConstants grid;
    float per_m2;  // proxies
};

/// A voxel's proxies and the light they send on, all together.
struct ProxyVoxel {
    vec3 middle;  // the centroid of its flux, or of its proxies where there is none [m]
    uint first;   // of the proxies, half open
    vec3 flux_w;
    uint end;
    vec3 flux_normal_w[3];  // by channel: sum of flux times normal
    float lit_m2;           // of the surface that its proxies with light stand for
    vec3 lit_normal_m2;     // sum of that times normal
    float dark_m2;          // of those without
};

#ifdef __cplusplus
static_assert(sizeof(ProxyVoxel) == 88, "must match the scalar layout of GLSL");
}  // namespace photond::gpu
#endif

#endif
