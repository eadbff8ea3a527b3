// For both compilers.
#ifndef PHOTOND_TRACE_RAYS_SHARED_H
#define PHOTOND_TRACE_RAYS_SHARED_H

#define TRACE_RAYS_GROUP 64
#define TRACE_RAYS_ANY_ID 32  // specialisation constant: only whether anything is met

#ifdef __cplusplus
namespace photond::gpu {
using uint = uint32_t;
#endif

struct TraceRaysPush {
    uint count;
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
