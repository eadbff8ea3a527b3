#pragma once
// Radial kernels of density estimation on a disc. Each integrates to 1 over the disc of radius r in the plane.

#include "renderer/core/lane_math.h"
#include "renderer/photons/kernel_shared.h"

namespace photond {

enum class KernelShape : uint8_t { Constant, Cone, Gaussian, Epanechnikov };
static_assert(int(KernelShape::Constant) == KERNEL_CONSTANT && int(KernelShape::Cone) == KERNEL_CONE &&
              int(KernelShape::Gaussian) == KERNEL_GAUSSIAN && int(KernelShape::Epanechnikov) == KERNEL_EPANECHNIKOV);

/// K(u; r) = shape(u^2 / r^2) / r^2 [m^-2], zero beyond r.
///   constant      1 / pi
///   cone          (1 - q / k) / ((1 - 2 / (3 k)) pi), q = u / r, k >= 1     [Jensen 1996], [Gumhold]
///   gaussian      [Jensen 2001, Eq. 7.8]'s w(q) = 1 - (1 - exp(-beta q^2 / 2)) / (1 - exp(-beta)), beta = 1.953,
///                 divided by its own integral over the disc, 0.579 pi (Jensen's factor 0.918 leaves 0.53 of the light)
///   epanechnikov  2 (1 - q^2) / pi
///
/// [Jensen 2001] Realistic Image Synthesis Using Photon Mapping. A K Peters.
class Kernel {
public:
    /// `cone_k` >= 1 (no cone below: it would turn negative); throws ErrorCode::OutOfRange.
    explicit Kernel(KernelShape shape, float cone_k = 1.1f);
    Kernel() : Kernel(KernelShape::Constant) {}

    KernelShape shape() const { return shape_; }
    float cone_k() const { return cone_k_; }

    /// K r^2 at q_sq = (u / r)^2 in [0, 1]; no test against 1.
    float operator()(float q_sq) const {
        switch (shape_) {
            case KernelShape::Constant: return scale_;
            case KernelShape::Cone: return scale_ - slope_ * std::sqrt(q_sq);
            case KernelShape::Gaussian: return scale_ - slope_ * (1 - std::exp(-0.5f * kGaussianBeta * q_sq));
            case KernelShape::Epanechnikov: return scale_ - slope_ * q_sq;
        }
        return 0;
    }

    /// The same, several at once.
    FloatLanes operator()(const FloatLanes& q_sq) const {
        switch (shape_) {
            case KernelShape::Constant: return scale_;
            case KernelShape::Cone: return scale_ - slope_ * std::experimental::sqrt(q_sq);
            case KernelShape::Gaussian:
                return scale_ - slope_ * (1.0f - exp2_lanes(-0.5f * kGaussianBeta * kLog2E * q_sq));
            case KernelShape::Epanechnikov: return scale_ - slope_ * q_sq;
        }
        return 0;
    }

    /// Share of the kernel within q = u / r of the centre: 0 at 0, 1 at 1 and beyond, closed form.
    float mass_within(float q) const;

    /// Mean of q^2 under the kernel: the bias in light that varies quadratically is twice that times the constant
    /// one's.
    float mean_q_sq() const;
    /// pi r^2 times the integral of K^2: the variance of a sum of photons over the constant kernel's.
    float roughness() const;

    /// Every kernel that does not rise outwards is a mixture of constant discs. Draws the radius of one of them, over
    /// r: the mean over `u`, uniform in [0, 1), of discs of integral 1 is the kernel.
    float sample_disc(float u) const;

    /// For the twin in kernel.glsl.
    gpu::KernelRecord device_record() const { return {static_cast<uint32_t>(shape_), scale_, slope_}; }

private:
    static constexpr float kGaussianBeta = KERNEL_GAUSSIAN_BETA;
    static constexpr float kLog2E = 1.44269504088896340736f;

    KernelShape shape_;
    float cone_k_;
    float scale_;      // at the centre
    float slope_ = 0;  // times what the shape falls by
};

}  // namespace photond
