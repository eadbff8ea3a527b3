#pragma once
// A BSDF seen from one direction, for many directions of light: what depends on wo alone is worked out once, and
// directions are taken several at a time. For density estimation, which asks for f of every photon and for no density;
// and for image-based lighting, which asks what the lobes make of light that is the same from everywhere.
//
// [Karis 2013] Real Shading in Unreal Engine 4.

#include "renderer/core/lanes.h"
#include "renderer/transport/bsdf.h"

namespace photond {

/// Shares of uniform light that lobes scatter to wo, deltas and refraction by solids apart: what the split sum
/// multiplies an environment by [Karis 2013].
struct LobeAlbedos {
    Rgb diffuse{0};
    Rgb reflected{0};    // GGX, about the mirrored direction
    Rgb transmitted{0};  // by a thin sheet, about the direction straight through
    float alpha = 1;     // of those two
};

class BsdfEvaluator {
public:
    BsdfEvaluator(const Bsdf& bsdf, const vec3& wo);

    /// What bsdf.f_cos(wo, wi) says of each direction, to rounding. `wi` unit.
    Vec3Lanes f_cos(const Vec3Lanes& wi) const;
    LobeAlbedos lobe_albedos() const;

private:
    Vec3Lanes diffuse(const FloatLanes& cos_i) const;
    void add_specular(const Vec3Lanes& wi, Vec3Lanes& f_cos) const;
    Rgb glass_albedo() const;
    void set_others(const Vec3Lanes& wi, const FloatMask& lanes, Vec3Lanes& f_cos) const;

    Bsdf bsdf_;
    vec3 wo_;
    Bsdf::LobeProbabilities lobes_;
    Rgb diffuse_{0};  // what of the diffuse lobe does not depend on wi
    bool has_coat_ = false, has_specular_ = false;
    bool has_others_below_ = false;  // lobes that transmit; evaluated one direction at a time
    bool has_glass_ = false;         // which reflects as well
    float stretched_cos_o_ = 0;      // Ggx::stretched_cos(wo)
};

}  // namespace photond
