// GLSL twin of photons/kernel.h: radial kernels of density estimation on a disc. Each integrates to 1 over the disc of
// radius r in the plane.
#ifndef PHOTOND_KERNEL_GLSL
#define PHOTOND_KERNEL_GLSL

#include "renderer/core/geometry.glsl"
#include "renderer/photons/kernel_shared.h"

/// K r^2 at q_sq = (u / r)^2 in [0, 1]; no test against 1.
float kernel_evaluate(KernelRecord kernel, float q_sq) {
    switch (kernel.shape) {
        case KERNEL_CONSTANT: return kernel.scale;
        case KERNEL_CONE: return kernel.scale - kernel.slope * sqrt(q_sq);
        case KERNEL_GAUSSIAN: return kernel.scale - kernel.slope * (1 - exp(-0.5 * KERNEL_GAUSSIAN_BETA * q_sq));
        default: return kernel.scale - kernel.slope * q_sq;
    }
}

/// Every kernel that does not rise outwards is a mixture of constant discs. Draws the radius of one of them, over r: the
/// mean over `u`, uniform in [0, 1), of discs of integral 1 is the kernel.
///
/// The discs up to radius q hold S(q) = integral of -pi t^2 K'(t) over t from 0 to q, and those of radius 1 the rest. S
/// is inverted, to 1e-6.
float kernel_sample_disc(KernelRecord kernel, float u) {
    u = max(u, 1.490116e-8);  // 2^-26
    switch (kernel.shape) {
        case KERNEL_CONSTANT: return 1.0;
        case KERNEL_CONE: return min(pow(3 * u / (PI * kernel.slope), 1.0 / 3), 1.0);  // S = pi slope q^3 / 3
        case KERNEL_EPANECHNIKOV: return sqrt(sqrt(u));                                // S = q^4
        default: break;
    }
    // S = pi slope (2 / beta) (1 - (1 + x) exp(-x)) with x = beta q^2 / 2 <= 0.9765: as a series, which cancels little,
    // and Newton's method. S is convex there: after the first step, which may pass the end, all come from above.
    const float kEnd = 0.5 * KERNEL_GAUSSIAN_BETA;
    const float wanted = u * KERNEL_GAUSSIAN_BETA / (2 * PI * kernel.slope);
    float x = min(sqrt(2 * wanted), kEnd);  // of the first term, x^2 / 2, alone
    for (int i = 0; i < 3 && x > 0; ++i) {
        float series = -1.0 / 3991680;
        series = series * x + 1.0 / 403200;
        series = series * x - 1.0 / 45360;
        series = series * x + 1.0 / 5760;
        series = series * x - 1.0 / 840;
        series = series * x + 1.0 / 144;
        series = series * x - 1.0 / 30;
        series = series * x + 1.0 / 8;
        series = series * x - 1.0 / 3;
        series = series * x + 1.0 / 2;
        x = min(x + (wanted - x * x * series) / (x * exp(-x)), kEnd);
    }
    return sqrt(x / kEnd);
}

#endif
