#pragma once
// What FLIP compares of each pixel of an image: its colour as filtered by the eye, and its edges and points.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/core/geometry.h"
#include "renderer/core/lanes.h"
#include "renderer/error/flip_color.h"
#include "renderer/error/flip_filters.h"

namespace photond {

/// One row of features: its planes one after the other, each padded to what is computed at once. The padding holds
/// finite numbers that mean nothing.
struct FeatureRow {
    static constexpr size_t kVectors = 4;  // at once, for one load of a weight and of a row's address
    static constexpr size_t kPlanes = 5;   // Hunt-adjusted L, a, b; strength of edge; strength of point

    static constexpr size_t kStep = kVectors * kLanes;

    static size_t plane_floats(uint32_t width) { return (width + kStep - 1) / kStep * kStep; }
    static size_t floats(uint32_t width) { return kPlanes * plane_floats(width); }
};

/// Goes down an image row by row and gives each row's features. Holds only as many filtered rows as the filters reach,
/// so that they stay in the cache. A row's features do not depend on where the scan began.
class FeatureScan {
public:
    FeatureScan(const FlipFilters& filters, Size2 size);

    /// From row `first` on, of 3 * size.pixels() scene-linear values; values that are not finite or negative count as
    /// 0. They are clamped to [0, 1], or with `exposure` [stops] scaled by 2^exposure and tone-mapped.
    void start(std::span<const float> image, std::optional<float> exposure, uint32_t first);
    /// Writes FeatureRow::floats(width) values of the next row.
    void next_row(float* features);

private:
    /// What of a row is kept: it filtered along x.
    enum Plane : uint32_t { Achromatic, RedGreen, BlueYellow0, BlueYellow1, Gaussian, Edge, Point, kPlanes };

    void take_row(uint32_t y);
    void gather_neighbours();
    void filter_down_columns(float* features) const;
    void convert_row(uint32_t y);
    void filter_along_row(float* filtered) const;
    FloatLanes displayed(const FloatLanes& value) const;

    const FlipFilters& filters_;
    const Size2 size_;
    const size_t plane_floats_;
    const size_t ring_rows_;

    const float* image_ = nullptr;
    std::optional<float> scale_;  // before tone mapping
    uint32_t row_ = 0;            // next_row()'s
    uint32_t taken_ = 0;          // rows below this one are filtered

    std::vector<float> rgb_;                // one row, three planes
    std::vector<float> opponent_;           // one row, three planes, with the edge values repeated to both sides
    std::vector<float> ring_;               // filtered rows: y at y % ring_rows_
    std::vector<const float*> neighbours_;  // the rows around row_, those beyond the image being its first or last
};

}  // namespace photond
