#pragma once
// How much of the light a GGX lobe with Schlick's Fresnel reflects: E(cos, roughness) = F0 A + F90 B.
//
// [Karis 2013] Real Shading in Unreal Engine 4 (the split into two factors).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/core/lanes.h"
#include "renderer/scene/delta_shared.h"
#include "renderer/transport/bsdf_albedo_table_shared.h"

namespace photond {

/// A and B over a grid of angles and roughnesses, interpolated linearly. Never below the truth (by more than rounding),
/// so that a base under a coat may have all that the table leaves.
class AlbedoTable {
public:
    static constexpr size_t kRows = ALBEDO_TABLE_ROWS, kColumns = ALBEDO_TABLE_COLUMNS;

    /// The table; made on first use (about 30 ms).
    static const AlbedoTable& get();
    /// The same without what keeps it above the truth: as near to it as interpolation comes, for what is no bound. Made
    /// on first use too.
    static const AlbedoTable& unraised();

    /// A roughness in [0, 1] as the row the lookups want; below DELTA_ROUGHNESS it stands for a mirror.
    static float row(float roughness) {
        const float least = std::sqrt(DELTA_ROUGHNESS);
        return roughness < DELTA_ROUGHNESS
                   ? ALBEDO_TABLE_MIRROR_ROW
                   : (std::sqrt(roughness) - least) / (1.0f - least) * static_cast<float>(kRows - 1);
    }

    /// (A, B) at `cos_theta` in [0, 1].
    vec2 directional(float cos_theta, float row) const {
        if (row < 0) {
            const float m = 1.0f - cos_theta, schlick = sqr(sqr(m)) * m;
            return {1.0f - schlick, schlick};
        }
        const Cell r = cell(row, kRows);
        const Cell c = cell(std::sqrt(std::sqrt(cos_theta)) * static_cast<float>(kColumns - 1), kColumns);
        const vec2* low = &directional_[r.index][c.index];
        const vec2* high = &directional_[r.index + 1][c.index];
        return (1 - r.fraction) * ((1 - c.fraction) * low[0] + c.fraction * low[1]) +
               r.fraction * ((1 - c.fraction) * high[0] + c.fraction * high[1]);
    }

    /// The same of several cosines.
    void directional(const FloatLanes& cos_theta, float row, FloatLanes& a, FloatLanes& b) const {
        if (row < 0) {
            const FloatLanes m = 1.0f - cos_theta, schlick = m * m * (m * m) * m;
            a = 1.0f - schlick, b = schlick;
            return;
        }
        const Cell r = cell(row, kRows);
        const FloatLanes position = sqrt(sqrt(cos_theta)) * static_cast<float>(kColumns - 1);
        alignas(FloatLanes) float positions[kLanes], as[kLanes], bs[kLanes];
        position.copy_to(positions, std::experimental::vector_aligned);
        for (size_t i = 0; i < kLanes; ++i) {
            const Cell c = cell(positions[i], kColumns);
            const vec2* low = &directional_[r.index][c.index];
            const vec2* high = &directional_[r.index + 1][c.index];
            const vec2 left = low[0] + r.fraction * (high[0] - low[0]),
                       right = low[1] + r.fraction * (high[1] - low[1]);
            const vec2 ab = left + c.fraction * (right - left);
            as[i] = ab.x, bs[i] = ab.y;
        }
        a.copy_from(as, std::experimental::vector_aligned);
        b.copy_from(bs, std::experimental::vector_aligned);
    }

    /// Cosine-weighted means over the hemisphere of exactly what directional() returns.
    vec2 average(float row) const {
        if (row < 0) return {20.0f / 21.0f, 1.0f / 21.0f};
        const Cell r = cell(row, kRows);
        return (1 - r.fraction) * average_[r.index] + r.fraction * average_[r.index + 1];
    }

    /// For the twin in bsdf_albedo_table.glsl: (A, B) row by row, then the rows' means.
    std::vector<vec2> device_data() const;
    static constexpr uint64_t device_bytes() { return (kRows * kColumns + kRows) * sizeof(vec2); }

private:
    struct Cell {
        size_t index;
        float fraction;
    };
    static Cell cell(float position, size_t nodes) {
        const size_t index = std::min(static_cast<size_t>(position), nodes - 2);
        return {index, position - static_cast<float>(index)};
    }

    explicit AlbedoTable(bool raised);
    void integrate_nodes();
    void raise_to_cover_cells();
    void average_rows();

    std::array<std::array<vec2, kColumns>, kRows> directional_;
    std::array<vec2, kRows> average_;
};

}  // namespace photond
