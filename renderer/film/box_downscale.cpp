#include "renderer/film/box_downscale.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "renderer/core/parallel.h"

namespace photond {

namespace {

/// The old pixels below new pixel `i` along one direction, first to last, and the share of it that each covers; calls
/// take(index, share).
template <class Take>
void for_each_below(uint32_t i, uint32_t from, uint32_t to, const Take& take) {
    const double step = double{1} * from / to;
    const double begin = i * step, end = i + 1 == to ? from : (i + 1) * step;
    for (auto k = static_cast<uint32_t>(begin); k < from && k < end; ++k) {
        const double share = (std::min(end, k + 1.0) - std::max(begin, double{1} * k)) / step;
        if (share > 0) take(k, share);
    }
}

}  // namespace

Size2 size_within(Size2 size, uint32_t max_side) {
    const uint32_t longer = std::max(size.width, size.height);
    if (longer <= max_side) return size;
    const auto scaled = [&](uint32_t side) {
        return std::max(1u, static_cast<uint32_t>(std::lround(double{1} * side * max_side / longer)));
    };
    return {scaled(size.width), scaled(size.height)};
}

std::vector<float> box_downscaled(std::span<const float> values, uint32_t channels, Size2 from, Size2 to) {
    assert(values.size() == from.pixels() * channels);
    assert(to.width >= 1 && to.width <= from.width && to.height >= 1 && to.height <= from.height);
    std::vector<float> scaled(to.pixels() * channels);
    const size_t row_values = size_t{from.width} * channels;
    parallel_for(to.height, 8, [&](size_t y) {
        std::vector<double> row(row_values);  // the old rows below this one, each by its share
        for_each_below(static_cast<uint32_t>(y), from.height, to.height, [&](uint32_t old_y, double share) {
            const float* in = values.data() + old_y * row_values;
            for (size_t i = 0; i < row_values; ++i) row[i] += share * double{in[i]};
        });
        float* out = scaled.data() + y * to.width * channels;
        for (uint32_t x = 0; x < to.width; ++x, out += channels)
            for (uint32_t k = 0; k < channels; ++k) {
                double sum = 0;
                for_each_below(x, from.width, to.width,
                               [&](uint32_t old_x, double share) { sum += share * row[old_x * channels + k]; });
                out[k] = static_cast<float>(sum);
            }
    });
    return scaled;
}

}  // namespace photond
