#pragma once
// One path between two of its vertices.

#include <array>
#include <cstdint>

#include "renderer/core/rgb.h"

namespace photond {

/// The solids a ray is in, innermost last. Deeper nesting than kDepth replaces the innermost.
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

private:
    uint32_t size_ = 0;
    std::array<uint32_t, kDepth> materials_;
};

struct Path {
    Rgb throughput{1};
    float pdf_sa = 0;     // with which the ray's direction was drawn
    vec3 position{0};     // of the last vertex; with lit_normal as given to the light sampler
    float eta_scale = 1;  // squared index of the medium the ray is in, which throughput is divided by
    vec3 lit_normal{0};
    uint32_t pixel = 0;
    uint32_t scatterings = 0;  // conventions.md: from the first non-delta vertex x_1 on
    bool delta = true;         // the last scattering was a delta lobe's, or there was none: no light sample competes
    bool caustic = true;       // all scatterings after x_1 were delta
    MediumStack media;
};

}  // namespace photond
