#include "clients/cli/hard_cases_pixels.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <functional>

#include "clients/cli/failure.h"

namespace photond::cli {

namespace {

// A pixel this much of which lies in a region lies wholly in it: regions are fractions in decimal.
constexpr double kAlmostAll = 1 - 1e-6;

/// How much of the pixel [i, i + 1) lies in [low, high).
double covered(uint32_t i, double low, double high) {
    return std::max(0.0, std::min(high, i + 1.0) - std::max(low, static_cast<double>(i)));
}

/// Calls visit(x, y, share of the pixel in the region) where the share is not 0.
template <class Visit>
void for_each_pixel(ImageSize size, const ImageRegion& region, const Visit& visit) {
    for (uint32_t y = 0; y < size.height; ++y) {
        const double rows = covered(y, region.y0 * size.height, region.y1 * size.height);
        if (rows <= 0) continue;
        for (uint32_t x = 0; x < size.width; ++x)
            if (const double share = rows * covered(x, region.x0 * size.width, region.x1 * size.width); share > 0)
                visit(x, y, share);
    }
}

WorstPixel worst_of(const MeanLayer& layer, const ImageRegion& region, double scale,
                    const std::function<Radiance(uint32_t, uint32_t)>& answer) {
    WorstPixel worst;
    for_each_pixel(layer.size(), region, [&](uint32_t x, uint32_t y, double share) {
        if (share < kAlmostAll) return;
        const Radiance pixel = layer.pixel(x, y), expected = answer(x, y);
        for (size_t c = 0; c < kChannels; ++c) {
            const double deviation = (pixel[c] - expected[c]) / scale;
            if (!worst.found || std::abs(deviation) > std::abs(worst.deviation)) worst = {x, y, deviation, true};
        }
    });
    return worst;
}

}  // namespace

LayerPixels layer_from(std::string_view raw, ImageSize size) {
    LayerPixels layer{size, std::vector<float>(kChannels * size.width * size.height)};
    if (raw.size() != layer.rgb.size() * sizeof(float))
        throw Failure("a layer's pixels are " + std::to_string(raw.size()) + " bytes, " +
                          std::to_string(layer.rgb.size() * sizeof(float)) + " were expected",
                      nullptr);
    std::memcpy(layer.rgb.data(), raw.data(), raw.size());  // the wire is little-endian, as is every host we build for
    return layer;
}

PixelFaults& PixelFaults::operator+=(const PixelFaults& more) {
    nan += more.nan;
    infinite += more.infinite;
    negative += more.negative;
    return *this;
}

PixelFaults faults_of(const LayerPixels& layer) {
    PixelFaults faults;
    for (const float value : layer.rgb) {
        faults.nan += std::isnan(value);
        faults.infinite += std::isinf(value);
        faults.negative += value < 0;
    }
    return faults;
}

Radiance region_mean(const LayerPixels& layer, const ImageRegion& region) {
    Radiance sum{};
    double area = 0;
    for_each_pixel(layer.size, region, [&](uint32_t x, uint32_t y, double share) {
        const float* rgb = &layer.rgb[kChannels * (size_t{y} * layer.size.width + x)];
        area += share;
        for (size_t c = 0; c < kChannels; ++c)
            if (std::isfinite(rgb[c])) sum[c] += share * static_cast<double>(rgb[c]);
    });
    if (area <= 0) throw Failure("a hard case's check has a region without pixels", nullptr);
    for (double& channel : sum) channel /= area;
    return sum;
}

void MeanLayer::add(const LayerPixels& layer) {
    if (count_ == 0) {
        size_ = layer.size;
        sums_.assign(layer.rgb.size(), 0);
    }
    assert(size_ == layer.size);
    for (size_t i = 0; i < sums_.size(); ++i)
        if (std::isfinite(layer.rgb[i])) sums_[i] += static_cast<double>(layer.rgb[i]);
    ++count_;
}

Radiance MeanLayer::pixel(uint32_t x, uint32_t y) const {
    const double* sum = &sums_[kChannels * (size_t{y} * size_.width + x)];
    return {sum[0] / count_, sum[1] / count_, sum[2] / count_};
}

WorstPixel worst_pixel(const MeanLayer& layer, const ImageRegion& region, const Radiance& answer, double scale) {
    return worst_of(layer, region, scale, [&](uint32_t, uint32_t) { return answer; });
}

WorstPixel worst_pixel(const MeanLayer& layer, const ImageRegion& region, const MeanLayer& other, double factor,
                       double scale) {
    assert(layer.size() == other.size());
    return worst_of(layer, region, scale, [&](uint32_t x, uint32_t y) {
        Radiance expected = other.pixel(x, y);
        for (double& channel : expected) channel *= factor;
        return expected;
    });
}

}  // namespace photond::cli
