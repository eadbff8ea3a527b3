#pragma once
// How much of the light a GGX lobe with Schlick's Fresnel reflects: E(cos, roughness) = F0 A + F90 B.
//
// [Karis 2013] Real Shading in Unreal Engine 4 (the split into two factors).

#include <array>
#include <cmath>
#include <cstddef>

#include "renderer/core/geometry.h"

namespace photond {

/// A and B, computed once for a grid of angles and roughnesses and interpolated linearly between them.
class AlbedoTable {
public:
    static constexpr size_t kRows = 48;     // roughness, evenly from 0 to 1
    static constexpr size_t kColumns = 48;  // sqrt(cos), evenly from 0 to 1: finer towards grazing

    /// The table; made on first use (some 10 ms).
    static const AlbedoTable& get();

    /// (A, B) at cosine `cos_theta` and roughness (alpha is its square), both in [0, 1].
    vec2 directional(float cos_theta, float roughness) const {
        const Cell row = cell(roughness, kRows), column = cell(std::sqrt(cos_theta), kColumns);
        const std::array<vec2, kColumns>& low = directional_[row.index];
        const std::array<vec2, kColumns>& high = directional_[row.index + 1];
        const size_t c = column.index;
        return (1 - row.fraction) * ((1 - column.fraction) * low[c] + column.fraction * low[c + 1]) +
               row.fraction * ((1 - column.fraction) * high[c] + column.fraction * high[c + 1]);
    }

    /// Cosine-weighted means over the hemisphere of exactly what directional() returns.
    vec2 average(float roughness) const {
        const Cell row = cell(roughness, kRows);
        return (1 - row.fraction) * average_[row.index] + row.fraction * average_[row.index + 1];
    }

private:
    AlbedoTable();

    struct Cell {
        size_t index;
        float fraction;
    };
    static Cell cell(float x, size_t nodes) {
        const float position = std::fmin(std::fmax(x, 0.0f), 1.0f) * static_cast<float>(nodes - 1);
        const size_t index = std::min(static_cast<size_t>(position), nodes - 2);
        return {index, position - static_cast<float>(index)};
    }

    std::array<std::array<vec2, kColumns>, kRows> directional_;
    std::array<vec2, kRows> average_;
};

}  // namespace photond
