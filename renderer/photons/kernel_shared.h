// A Kernel (kernel.h) as shaders see it (kernel.glsl): for both compilers.
#ifndef PHOTOND_KERNEL_SHARED_H
#define PHOTOND_KERNEL_SHARED_H

#define KERNEL_CONSTANT 0  // KernelShape
#define KERNEL_CONE 1
#define KERNEL_GAUSSIAN 2
#define KERNEL_EPANECHNIKOV 3
#define KERNEL_GAUSSIAN_BETA 1.953f

#ifdef __cplusplus
#include <cstdint>
namespace photond::gpu {
using uint = uint32_t;
#endif

struct KernelRecord {
    uint shape;
    float scale;  // at the centre
    float slope;  // times what the shape falls by
};

#ifdef __cplusplus
}  // namespace photond::gpu
#endif

#endif
