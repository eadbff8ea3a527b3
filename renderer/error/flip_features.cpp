#include "renderer/error/flip_features.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "renderer/error/aces_tone_curve.h"

namespace photond {

namespace {

namespace stdx = std::experimental;

// The loops over a row are flattened: left to itself the compiler calls the vectors' own operators one by one.

FloatLanes load(const float* from) { return FloatLanes(from, stdx::element_aligned); }
void store(const FloatLanes& lanes, float* to) { lanes.copy_to(to, stdx::element_aligned); }

/// Consecutive vectors of a row.
struct Tile {
    std::array<FloatLanes, FeatureRow::kVectors> v;
};
template <class Operation>
Tile each(const Operation& operation) {
    Tile result;
    for (size_t i = 0; i < result.v.size(); ++i) result.v[i] = operation(i);
    return result;
}
Tile operator+(const Tile& a, const Tile& b) {
    return each([&](size_t i) { return a.v[i] + b.v[i]; });
}
Tile operator-(const Tile& a, const Tile& b) {
    return each([&](size_t i) { return a.v[i] - b.v[i]; });
}
Tile operator*(float weight, const Tile& a) {
    return each([&](size_t i) { return weight * a.v[i]; });
}
void add_weighted(Tile& sum, float weight, const Tile& a) {
    for (size_t i = 0; i < sum.v.size(); ++i) sum.v[i] += weight * a.v[i];
}
Tile load_tile(const float* from) {
    return each([&](size_t i) { return load(from + i * kLanes); });
}
void store(const Tile& tile, float* to) {
    for (size_t i = 0; i < tile.v.size(); ++i) store(tile.v[i], to + i * kLanes);
}
Tile length(const Tile& x, const Tile& y) {
    return each([&](size_t i) { return stdx::sqrt(x.v[i] * x.v[i] + y.v[i] * y.v[i]); });
}

// Below, `at(k)` gives the values k pixels on, along x or along y. Each filter takes the two sides together: of a flat
// neighbourhood an odd filter and a second derivative are then exactly 0, which matters because the difference of
// features goes through a square root.

template <class At>
Tile smooth(const HalfFilter& filter, const At& at) {
    Tile sum = filter[0] * at(0);
    for (std::ptrdiff_t k = 1; k < std::ssize(filter); ++k)
        add_weighted(sum, filter[static_cast<size_t>(k)], at(k) + at(-k));
    return sum;
}

struct Detected {
    Tile gaussian, edge, point;
};
/// All filters of the detectors at once: they read the same values. The point filter's weights add up to 0, so that of
/// its centre need not be taken: it goes with the differences from the centre.
template <bool with_gaussian, class At>
Detected detect(const FlipFilters& filters, const At& at) {
    const Tile centre = at(0), twice = centre + centre;
    Detected sum{filters.gaussian[0] * centre, 0.0f * centre, 0.0f * centre};
    for (std::ptrdiff_t k = 1; k < std::ssize(filters.gaussian); ++k) {
        const auto i = static_cast<size_t>(k);
        const Tile after = at(k), before = at(-k), both = after + before;
        if constexpr (with_gaussian) add_weighted(sum.gaussian, filters.gaussian[i], both);
        add_weighted(sum.edge, filters.edge[i], after - before);
        add_weighted(sum.point, filters.point[i], both - twice);
    }
    return sum;
}

FloatLanes clamped(const FloatLanes& x) { return stdx::min(stdx::max(x, FloatLanes(0.0f)), FloatLanes(1.0f)); }

}  // namespace

FeatureScan::FeatureScan(const FlipFilters& filters, Size2 size)
    : filters_(filters),
      size_(size),
      plane_floats_(FeatureRow::plane_floats(size.width)),
      ring_rows_(2 * filters.radius + 1),
      rgb_(3 * plane_floats_),
      opponent_(3 * (plane_floats_ + 2 * filters.radius)),
      ring_(ring_rows_ * kPlanes * plane_floats_),
      neighbours_(ring_rows_) {}

void FeatureScan::start(std::span<const float> image, std::optional<float> exposure, uint32_t first) {
    assert(image.size() == 3 * size_.pixels() && first < size_.height);
    image_ = image.data();
    scale_ = exposure ? std::optional(std::exp2(*exposure)) : std::nullopt;
    row_ = first;
    taken_ = first - std::min(first, static_cast<uint32_t>(filters_.radius));
}

/// Clamping to [0, 1] stands for the sRGB encoding and decoding of an 8-bit display path, which cancel.
FloatLanes FeatureScan::displayed(const FloatLanes& value) const {
    const FloatLanes finite = select(value > 0.0f && value < kInfinity, value, 0.0f);  // NaN: 0
    return scale_ ? AcesToneCurve::at(finite * *scale_) : stdx::min(finite, FloatLanes(1.0f));
}

/// Row y of the image in the opponent space, in opponent_.
[[gnu::flatten]] void FeatureScan::convert_row(uint32_t y) {
    const float* pixels = image_ + size_t{3} * size_.width * y;
    float *r = rgb_.data(), *g = r + plane_floats_, *b = g + plane_floats_;
    for (size_t x = 0; x < size_.width; ++x) r[x] = pixels[3 * x], g[x] = pixels[3 * x + 1], b[x] = pixels[3 * x + 2];

    const size_t stride = plane_floats_ + 2 * filters_.radius;
    std::array<float*, 3> planes{};
    for (size_t i = 0; i < 3; ++i) planes[i] = opponent_.data() + i * stride + filters_.radius;
    for (size_t x = 0; x < plane_floats_; x += kLanes) {
        const OpponentLanes opponent =
            opponent_from_rgb({displayed(load(r + x)), displayed(load(g + x)), displayed(load(b + x))});
        store(opponent.y, planes[0] + x);
        store(opponent.cx, planes[1] + x);
        store(opponent.cz, planes[2] + x);
    }
    for (float* plane : planes) {
        std::fill(plane - filters_.radius, plane, plane[0]);
        std::fill(plane + size_.width, plane + plane_floats_ + filters_.radius, plane[size_.width - 1]);
    }
}

[[gnu::flatten]] void FeatureScan::filter_along_row(float* filtered) const {
    const size_t stride = plane_floats_ + 2 * filters_.radius;
    const float* y = opponent_.data() + filters_.radius;
    const float *cx = y + stride, *cz = cx + stride;
    const auto out = [&](Plane plane) { return filtered + plane * plane_floats_; };
    for (size_t x = 0; x < plane_floats_; x += FeatureRow::kStep) {
        const auto along = [x](const float* plane) {
            return [at = plane + x](std::ptrdiff_t k) { return load_tile(at + k); };
        };
        store(smooth(filters_.achromatic, along(y)), out(Achromatic) + x);
        store(smooth(filters_.red_green, along(cx)), out(RedGreen) + x);
        store(smooth(filters_.blue_yellow[0], along(cz)), out(BlueYellow0) + x);
        store(smooth(filters_.blue_yellow[1], along(cz)), out(BlueYellow1) + x);
        const Detected detected = detect<true>(filters_, along(y));
        store(detected.gaussian, out(Gaussian) + x);
        store(detected.edge, out(Edge) + x);
        store(detected.point, out(Point) + x);
    }
}

void FeatureScan::take_row(uint32_t y) {
    convert_row(y);
    filter_along_row(ring_.data() + y % ring_rows_ * kPlanes * plane_floats_);
}

void FeatureScan::next_row(float* features) {
    assert(row_ < size_.height);
    gather_neighbours();
    filter_down_columns(features);
    ++row_;
}

void FeatureScan::gather_neighbours() {
    const auto radius = static_cast<int64_t>(filters_.radius), last = static_cast<int64_t>(size_.height) - 1;
    while (taken_ <= std::min(last, row_ + radius)) take_row(taken_++);
    for (int64_t k = -radius; k <= radius; ++k) {
        const auto y = static_cast<size_t>(std::clamp(row_ + k, int64_t{0}, last));
        neighbours_[static_cast<size_t>(k + radius)] = ring_.data() + y % ring_rows_ * kPlanes * plane_floats_;
    }
}

[[gnu::flatten]] void FeatureScan::filter_down_columns(float* features) const {
    const float* const* centre = neighbours_.data() + filters_.radius;
    const auto out = [&](size_t plane) { return features + plane * plane_floats_; };
    for (size_t x = 0; x < plane_floats_; x += FeatureRow::kStep) {
        const auto down = [&](Plane plane) {
            return [centre, offset = plane * plane_floats_ + x](std::ptrdiff_t k) {
                return load_tile(centre[k] + offset);
            };
        };
        const Tile y = smooth(filters_.achromatic, down(Achromatic)), cx = smooth(filters_.red_green, down(RedGreen));
        const Tile cz =
            smooth(filters_.blue_yellow[0], down(BlueYellow0)) + smooth(filters_.blue_yellow[1], down(BlueYellow1));
        for (size_t i = 0; i < FeatureRow::kVectors; ++i) {
            const RgbLanes rgb = rgb_from_opponent({y.v[i], cx.v[i], cz.v[i]});
            const HuntLabLanes lab = hunt_lab_from_rgb({clamped(rgb.r), clamped(rgb.g), clamped(rgb.b)});
            const size_t at = x + i * kLanes;
            store(lab.l, out(0) + at);
            store(lab.a, out(1) + at);
            store(lab.b, out(2) + at);
        }
        const Detected along_y = detect<false>(filters_, down(Gaussian));
        store(length(smooth(filters_.gaussian, down(Edge)), along_y.edge), out(3) + x);
        store(length(smooth(filters_.gaussian, down(Point)), along_y.point), out(4) + x);
    }
}

}  // namespace photond
