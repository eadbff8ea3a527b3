#include "renderer/gbuffer/indirect_blur.h"

#include <array>
#include <cassert>
#include <cmath>

#include "renderer/core/lane_math.h"
#include "renderer/core/parallel.h"

namespace photond {

namespace {

constexpr uint32_t kMostWidth = 9, kMostRadius = kMostWidth / 2;
constexpr size_t kRowGrain = 8;

/// Weights of the pixels 0 ... radius away: exp(-k^2 / (2 s^2)), s = width / 4. Not divided by their sum.
struct Kernel {
    uint32_t radius;
    std::array<float, kMostRadius + 1> weight{};

    explicit Kernel(uint32_t width) : radius(width / 2) {
        for (uint32_t k = 0; k <= radius; ++k)
            weight[k] = static_cast<float>(std::exp(-8.0 * k * k / (double(width) * width)));
    }
    float at(ptrdiff_t offset) const { return weight[static_cast<size_t>(std::abs(offset))]; }
};

/// Pixels that lie one behind the other in memory, `step` apart in the direction that is blurred: a row (step 1), or
/// one of each column (step: the image's width).
struct Pixels {
    size_t first;
    size_t count;
    ptrdiff_t step;
};

/// One pass of the blur from `in` to `out` over one row of the image, along rows or along columns.
class RowBlur {
public:
    RowBlur(std::span<const Rgb> in, std::span<Rgb> out, Size2 size, const Kernel& kernel, const BlurEdges& edges)
        : in_(in), out_(out), size_(size), kernel_(kernel), edges_(edges) {}

    void along_row(uint32_t y) const {
        // The pixels whose neighbours on both sides all lie in the row, and those near its ends one by one.
        const uint32_t width = size_.width, radius = kernel_.radius;
        const size_t row = size_t{y} * width;
        const uint32_t left = std::min(radius, width), right = std::max(left, width - std::min(radius, width));
        for (uint32_t x = 0; x < left; ++x) blur({row + x, 1, 1}, -int(x), int(width - 1 - x));
        if (right > left) blur({row + left, right - left, 1}, -int(radius), int(radius));
        for (uint32_t x = right; x < width; ++x) blur({row + x, 1, 1}, -int(x), int(width - 1 - x));
    }
    void along_columns(uint32_t y) const {
        blur({size_t{y} * size_.width, size_.width, ptrdiff_t(size_.width)}, -int(y), int(size_.height - 1 - y));
    }

private:
    /// Offsets from `first` to `last`, cut to the kernel.
    void blur(const Pixels& pixels, int first, int last) const {
        const int radius = int(kernel_.radius);
        first = std::max(first, -radius), last = std::min(last, radius);
        if (edges_.normal.empty() && edges_.depth.empty()) {
            blur_plain(pixels, first, last);
        } else {
            blur_within_edges(pixels, first, last);
        }
    }
    void blur_plain(const Pixels& pixels, int first, int last) const;
    void blur_within_edges(const Pixels& pixels, int first, int last) const;
    void weigh(size_t pixel, size_t neighbour, size_t count, float kernel_weight, float* weights) const;

    const std::span<const Rgb> in_;
    const std::span<Rgb> out_;
    const Size2 size_;
    const Kernel& kernel_;
    const BlurEdges& edges_;
};

/// Numbers of a span of colours, three a pixel.
const float* numbers(std::span<const Rgb> colors, size_t pixel) { return &colors[pixel].x; }

void RowBlur::blur_plain(const Pixels& pixels, int first, int last) const {
    static_assert(sizeof(Rgb) == 3 * sizeof(float));
    float sum = 0;
    for (int k = first; k <= last; ++k) sum += kernel_.at(k);
    constexpr size_t kBlock = 512;  // numbers, which stay in registers and the first cache
    std::array<float, kBlock> blurred;
    const float* in = numbers(in_, pixels.first);
    float* out = &out_[pixels.first].x;
    for (size_t begin = 0; begin < 3 * pixels.count; begin += kBlock) {
        const size_t count = std::min(kBlock, 3 * pixels.count - begin);
        blurred.fill(0);
        for (int k = first; k <= last; ++k) {
            const float weight = kernel_.at(k) / sum;
            const float* neighbour = in + ptrdiff_t(begin) + 3 * k * pixels.step;
            for (size_t i = 0; i < count; ++i) blurred[i] += weight * neighbour[i];
        }
        std::copy_n(blurred.data(), count, out + begin);
    }
}

/// Block of pixels whose weights and sums are held at a time.
constexpr size_t kEdgeBlock = 64;
static_assert(kEdgeBlock % kLanes == 0);

void RowBlur::blur_within_edges(const Pixels& pixels, int first, int last) const {
    for (size_t begin = 0; begin < pixels.count; begin += kEdgeBlock) {
        const size_t count = std::min(kEdgeBlock, pixels.count - begin), pixel = pixels.first + begin;
        std::array<float, kEdgeBlock> weights, weight_sum{};
        std::array<float, 3 * kEdgeBlock> blurred{};
        for (int k = first; k <= last; ++k) {
            const size_t neighbour = pixel + size_t(k * pixels.step);
            if (k == 0) {
                weights.fill(kernel_.at(0));  // whatever lies there, it is on its own surface
            } else {
                weigh(pixel, neighbour, count, kernel_.at(k), weights.data());
            }
            const float* color = numbers(in_, neighbour);
            for (size_t i = 0; i < count; ++i) {
                weight_sum[i] += weights[i];
                for (size_t c = 0; c < 3; ++c) blurred[3 * i + c] += weights[i] * color[3 * i + c];
            }
        }
        for (size_t i = 0; i < count; ++i) {
            const float scale = 1 / weight_sum[i];
            for (int c = 0; c < 3; ++c) out_[pixel + i][c] = scale * blurred[3 * i + size_t(c)];
        }
    }
}

void RowBlur::weigh(size_t pixel, size_t neighbour, size_t count, float kernel_weight, float* weights) const {
    // kernel max(0, n . n')^p exp(-((z - z') / (r z))^2) as one power of two.
    constexpr float kLog2E = 1.44269504088896341f;
    constexpr float kNothing = -200;  // the logarithm of less than the smallest number: no weight
    std::array<float, kEdgeBlock> cosine, difference;
    cosine.fill(1), difference.fill(0);
    if (!edges_.normal.empty())
        for (size_t i = 0; i < count; ++i) cosine[i] = glm::dot(edges_.normal[pixel + i], edges_.normal[neighbour + i]);
    if (!edges_.depth.empty()) {
        for (size_t i = 0; i < count; ++i) {
            const float z = edges_.depth[pixel + i], other = edges_.depth[neighbour + i];
            const float scaled = (z - other) / std::max(edges_.relative_depth * z, 1e-30f);
            const bool met = z < kInfinity, other_met = other < kInfinity;  // NaN: nothing was met either
            difference[i] = met && other_met ? scaled : met == other_met ? 0 : kInfinity;
            if (!met && !other_met) cosine[i] = 1;  // normals of nothing
        }
    }
    for (size_t i = 0; i < count; i += kLanes) {
        FloatLanes c, d;
        c.copy_from(&cosine[i], std::experimental::element_aligned);
        d.copy_from(&difference[i], std::experimental::element_aligned);
        const FloatLanes least(1e-30f);
        const FloatLanes exponent = edges_.normal_power * log2_lanes(select(c > least, c, least)) - kLog2E * (d * d);
        const FloatLanes weight = kernel_weight * exp2_lanes(exponent);
        select(exponent > kNothing && c > 0.0f, weight, 0.0f).copy_to(weights + i, std::experimental::element_aligned);
    }
}

}  // namespace

void blur_layer(std::span<Rgb> image, Size2 size, uint32_t width, const BlurEdges& edges) {
    assert(width % 2 == 1 && width >= 3 && width <= kMostWidth && image.size() == size.pixels());
    assert((edges.normal.empty() || edges.normal.size() == image.size()) && "one normal a pixel, or none");
    assert((edges.depth.empty() || edges.depth.size() == image.size()) && "one depth a pixel, or none");
    if (image.empty()) return;
    const Kernel kernel(width);
    std::vector<Rgb> rows_blurred(image.size());
    const RowBlur rows(image, rows_blurred, size, kernel, edges), columns(rows_blurred, image, size, kernel, edges);
    parallel_for(size.height, kRowGrain, [&](size_t y) { rows.along_row(static_cast<uint32_t>(y)); });
    parallel_for(size.height, kRowGrain, [&](size_t y) { columns.along_columns(static_cast<uint32_t>(y)); });
}

}  // namespace photond
