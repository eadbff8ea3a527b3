#pragma once
// Which solids a ray is in, and what they absorb of the light on its way.

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/scene/scene.h"

namespace photond {

/// The solids a ray is in, innermost last. Deeper nesting than kDepth replaces the innermost.
///
/// Where solids overlap, the last one entered fills the place: entered through its front, it bends the ray; left while
/// another was entered since, it does not, for on both sides of its surface is that other one. So a liquid may reach
/// into its glass, and solids that touch are made to (scene/touching_solids.h).
class MediumStack {
public:
    static constexpr uint32_t kDepth = 4;
    static constexpr uint32_t kVacuum = ~0u;

    /// Material of the innermost solid, kVacuum outside of all.
    uint32_t top() const { return size_ > 0 ? materials_[size_ - 1] : kVacuum; }

    /// What lies outside of a surface of `material`: seen from within, the solid below its innermost occurrence.
    uint32_t outside_of(uint32_t material, bool seen_from_within) const {
        if (!seen_from_within) return top();
        MediumStack rest = *this;
        rest.leave(material);
        return rest.top();
    }
    /// Index of refraction of what lies outside of a surface: 1 where that is no solid, the material's own where the
    /// surface bends nothing.
    float outside_ior(const Scene& scene, uint32_t material, bool seen_from_within) const {
        const bool within_another = seen_from_within && top() != material && holds(material);
        const uint32_t outside = within_another ? material : outside_of(material, seen_from_within);
        return outside == kVacuum ? 1.0f : scene.materials[outside].ior;
    }

    void enter(uint32_t material) {
        if (size_ < kDepth) ++size_;
        materials_[size_ - 1] = material;
    }

    void leave(uint32_t material) {
        for (uint32_t i = size_; i-- > 0;) {
            if (materials_[i] != material) continue;
            for (; i + 1 < size_; ++i) materials_[i] = materials_[i + 1];
            --size_;
            return;
        }
    }

    /// After a refraction at a surface of `material`: in through its front, out through its back.
    void cross(uint32_t material, bool from_front) { from_front ? enter(material) : leave(material); }

private:
    bool holds(uint32_t material) const {
        for (uint32_t i = 0; i < size_; ++i)
            if (materials_[i] == material) return true;
        return false;
    }

    uint32_t size_ = 0;
    std::array<uint32_t, kDepth> materials_;
};

/// Beer's law by material: attenuation_color is what remains after attenuation_distance. Materials that absorb nothing
/// cost nothing.
class Absorption {
public:
    explicit Absorption(const Scene& scene);

    /// Share left of light that travelled `distance` [m] in the innermost solid of the stack; infinite distance:
    /// nothing where it absorbs at all.
    Rgb transmittance(const MediumStack& media, float distance) const {
        const uint32_t medium = media.top();
        return medium == MediumStack::kVacuum ? Rgb(1) : transmittance(per_m_[medium], distance);
    }

private:
    static Rgb transmittance(const Rgb& absorption_per_m, float distance);

    std::vector<Rgb> per_m_;  // by material [1/m]
};

}  // namespace photond
