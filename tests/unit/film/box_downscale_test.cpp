// Images made smaller keep their light where it was.

#include "renderer/film/box_downscale.h"

#include <gtest/gtest.h>

#include <numeric>

#include "renderer/core/rng.h"

namespace photond::box_downscale_test {
namespace {

std::vector<float> noise(Size2 size, uint32_t channels) {
    std::vector<float> values(size.pixels() * channels);
    RandomStream random(3, RandomDomain::Test, 0, 0);
    for (float& value : values) value = random.next();
    return values;
}

double mean(const std::vector<float>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

TEST(BoxDownscale, SizesKeepTheirShape) {
    EXPECT_EQ(size_within({640, 480}, 320), (Size2{320, 240}));
    EXPECT_EQ(size_within({480, 640}, 320), (Size2{240, 320}));
    EXPECT_EQ(size_within({640, 480}, 640), (Size2{640, 480}));
    EXPECT_EQ(size_within({640, 480}, 4096), (Size2{640, 480})) << "never larger";
    EXPECT_EQ(size_within({65536, 1}, 16), (Size2{16, 1})) << "never nothing";
    EXPECT_EQ(size_within({100, 67}, 10), (Size2{10, 7}));
}

TEST(BoxDownscale, WholeBlocksAreTheirMean) {
    // Two channels, 4 x 2 to 2 x 1.
    const std::vector<float> values{1, 10, 2, 20, 3, 30, 4, 40,  //
                                    5, 50, 6, 60, 7, 70, 8, 80};
    EXPECT_EQ(box_downscaled(values, 2, {4, 2}, {2, 1}), (std::vector<float>{3.5f, 35, 5.5f, 55}));
}

TEST(BoxDownscale, PixelsAcrossABorderAreShared) {
    const std::vector<float> scaled = box_downscaled(std::vector<float>{3, 6, 9}, 1, {3, 1}, {2, 1});
    ASSERT_EQ(scaled.size(), 2u);
    EXPECT_FLOAT_EQ(scaled[0], 4);  // 3 and half of 6
    EXPECT_FLOAT_EQ(scaled[1], 8);
    EXPECT_EQ(box_downscaled(std::vector<float>{3, 6, 9}, 1, {1, 3}, {1, 1}), std::vector<float>{6});
}

TEST(BoxDownscale, ItsOwnSizeIsTheSameImage) {
    const std::vector<float> values = noise({31, 17}, 3);
    EXPECT_EQ(box_downscaled(values, 3, {31, 17}, {31, 17}), values);
}

TEST(BoxDownscale, ConstantsAndMeansStay) {
    for (const Size2 to : {Size2{64, 33}, Size2{63, 7}, Size2{17, 32}, Size2{1, 1}}) {
        const Size2 from{97, 61};
        for (const float value : box_downscaled(std::vector<float>(3 * from.pixels(), 0.7f), 3, from, to))
            EXPECT_NEAR(value, 0.7f, 1e-6f);
        const std::vector<float> values = noise(from, 3);
        EXPECT_NEAR(mean(box_downscaled(values, 3, from, to)), mean(values), 1e-6) << to.width << " x " << to.height;
    }
}

}  // namespace
}  // namespace photond::box_downscale_test
