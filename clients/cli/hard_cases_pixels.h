#pragma once
// A layer as GET /v1/jobs/{id}/pixels gives it, and what is read off it.

#include <cstdint>
#include <string_view>
#include <vector>

#include "clients/cli/hard_cases_scenes.h"

namespace photond::cli {

/// RGB of every pixel, row 0 at the top.
struct LayerPixels {
    ImageSize size;
    std::vector<float> rgb;
};

/// Throws Failure(Refused) where `raw` is not RGB in 32-bit little-endian floats of that size.
LayerPixels layer_from(std::string_view raw, ImageSize size);

/// Numbers that no radiance may be, over all channels.
struct PixelFaults {
    uint64_t nan = 0, infinite = 0, negative = 0;
    uint64_t all() const { return nan + infinite + negative; }
    PixelFaults& operator+=(const PixelFaults& more);
};
PixelFaults faults_of(const LayerPixels& layer);

/// Mean over the region; a pixel that is partly in it counts by its share. Numbers that are not finite are left out,
/// they are counted elsewhere. Throws Failure(Refused) for a region without area.
Radiance region_mean(const LayerPixels& layer, const ImageRegion& region);

/// The sum of several renderings of one layer, for what single pixels tend to.
class MeanLayer {
public:
    void add(const LayerPixels& layer);
    bool empty() const { return count_ == 0; }
    ImageSize size() const { return size_; }
    /// Mean of the renderings, not finite ones left out.
    Radiance pixel(uint32_t x, uint32_t y) const;

private:
    ImageSize size_;
    std::vector<double> sums_;
    uint32_t count_ = 0;
};

/// The pixel wholly within the region that lies farthest from what it should be.
struct WorstPixel {
    uint32_t x = 0, y = 0;
    double deviation = 0;  // in the units asked for, with its sign
    bool found = false;    // some pixel lies wholly within the region
};
/// Deviations from `answer` (one radiance) in units of `scale`, channel by channel.
WorstPixel worst_pixel(const MeanLayer& layer, const ImageRegion& region, const Radiance& answer, double scale);
/// Deviations from the other image's pixels times `factor`. Images of one size.
WorstPixel worst_pixel(const MeanLayer& layer, const ImageRegion& region, const MeanLayer& other, double factor,
                       double scale);

}  // namespace photond::cli
