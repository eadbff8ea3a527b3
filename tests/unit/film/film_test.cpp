// The film's promise: any order of passes and any cut into ranges gives the same bits, and what it says of mean,
// variance and dropped values is true.

#include "renderer/film/film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "renderer/core/rng.h"
#include "tests/support/random_film.h"
#include "tests/support/threads.h"

namespace photond::film_test {
namespace {

LayerSet all_layers() { return LayerSet::all(); }

using test::film_of;

TEST(FixedSums, AreRoundedAsACastRoundsThem) {
    RandomStream random(5, RandomDomain::Test, 0, 0);
    const auto expect_equal = [](FixedSquares number) {
        EXPECT_EQ(nearest_double(number), static_cast<double>(number));
        EXPECT_EQ(nearest_double(static_cast<FixedSum>(number)), static_cast<double>(static_cast<FixedSum>(number)));
    };
    const auto bits = [&] { return uint64_t{random.next_bits()} << 32 | random.next_bits(); };
    for (int i = 0; i < 20000; ++i) {
        const FixedSquares number = FixedSquares{bits()} << 64 | bits();
        expect_equal(number >> (i % 128));
        expect_equal(number >> (i % 128) << (i % 77));  // zeros below
    }
    for (int i = 0; i < 128; ++i)  // halfway between two doubles, and beside that
        for (const FixedSquares odd : {FixedSquares{1}, FixedSquares{3}}) {
            const FixedSquares halfway = (FixedSquares{1} << i) | (i >= 53 ? odd << (i - 53) : FixedSquares{0});
            expect_equal(halfway - 1), expect_equal(halfway), expect_equal(halfway + 1);
        }
}

TEST(Film, AnyOrderOfPassesGivesTheSameBits) {
    const Size2 size{37, 11};
    std::vector<uint32_t> order(24);
    std::iota(order.begin(), order.end(), 0u);
    const Film forward = film_of(size, all_layers(), order);
    std::reverse(order.begin(), order.end());
    EXPECT_TRUE(forward == film_of(size, all_layers(), order));
    std::rotate(order.begin(), order.begin() + 7, order.end());
    const Film rotated = film_of(size, all_layers(), order);
    EXPECT_TRUE(forward == rotated);
    EXPECT_EQ(forward.pixel_hash(), rotated.pixel_hash());
    order[0] = 99;  // another pass: the comparison can fail
    EXPECT_FALSE(forward == film_of(size, all_layers(), order));
}

TEST(Film, AnyNumberOfThreadsGivesTheSameBits) {
    const Size2 size{256, 64};
    const auto render = [&](int threads) {
        return test::on_threads(threads, [&] { return film_of(size, all_layers(), {0, 1, 2}).pixel_hash(); });
    };
    const std::string one = render(1);
    EXPECT_EQ(one, render(2));
    EXPECT_EQ(one, render(7));
}

// 0.1f + 1e8f loses the small value in float; here the sums are exact, so the mean is the true one rounded once.
TEST(Film, SumsLoseNothing) {
    const Size2 size{1, 1};
    Film film(size, LayerSet());
    PassImage pass(size, LayerSet());
    pass.of<Layer::Direct>()[0] = Rgb(1e8f, 0x1p-64f, 0x1p-66f);
    film.add_pass(pass);
    pass.of<Layer::Direct>()[0] = Rgb(-1e8f, 0x1p-64f, 0x1p-66f);
    film.add_pass(pass);
    pass.of<Layer::Direct>()[0] = Rgb(0.1f, 0, 0);
    pass.of<Layer::Indirect>()[0] = Rgb(0.2f, 0, 0);
    film.add_pass(pass);
    const std::vector<float> direct = film.resolve(Layer::Direct);
    EXPECT_EQ(direct[0], static_cast<float>(double{0.1f} / 3));
    EXPECT_EQ(direct[1], static_cast<float>(0x1p-63 / 3));
    EXPECT_EQ(direct[2], 0.0f);  // below half of the resolution
    EXPECT_EQ(film.resolve_beauty()[0], static_cast<float>((double{0.1f} + double{0.2f}) / 3));
}

TEST(Film, MeansAndVariancesAreThoseOfTheValues) {
    const Size2 size{5, 3};
    constexpr uint32_t kPasses = 50;
    Film film(size, all_layers());
    std::vector<double> sum(3 * size.pixels()), square(3 * size.pixels());
    std::vector<double> direct_sum(sum), direct_square(sum);
    for (uint32_t p = 0; p < kPasses; ++p) {
        PassImage pass(size, all_layers());
        for (size_t i = 0; i < size.pixels(); ++i) {
            RandomStream random(3, RandomDomain::Test, p, i);
            for (int k = 0; k < 3; ++k) {
                pass.of<Layer::Emitted>()[i][k] = random.next(), pass.of<Layer::Direct>()[i][k] = random.next();
                pass.of<Layer::Indirect>()[i][k] = random.next();
                const double beauty = double{pass.of<Layer::Emitted>()[i][k]} + double{pass.of<Layer::Direct>()[i][k]} +
                                      double{pass.of<Layer::Indirect>()[i][k]};
                const size_t at = 3 * i + static_cast<size_t>(k);
                sum[at] += beauty, square[at] += beauty * beauty;
                direct_sum[at] += double{pass.of<Layer::Direct>()[i][k]};
                direct_square[at] += double{pass.of<Layer::Direct>()[i][k]} * double{pass.of<Layer::Direct>()[i][k]};
            }
        }
        film.add_pass(pass);
    }
    const std::vector<float> mean = film.resolve_beauty(), variance = film.pass_variance_beauty();
    const std::vector<float> direct_variance = film.pass_variance(Layer::Direct);
    const std::vector<float> error = film.resolve(Layer::StandardError);
    for (size_t i = 0; i < sum.size(); ++i) {
        EXPECT_NEAR(mean[i], sum[i] / kPasses, 1e-6);
        const double expected = (square[i] - sum[i] * sum[i] / kPasses) / (kPasses - 1);
        EXPECT_NEAR(variance[i], expected, 1e-6 * expected);
        EXPECT_NEAR(error[i], std::sqrt(expected / kPasses), 1e-6);
        const double direct = (direct_square[i] - direct_sum[i] * direct_sum[i] / kPasses) / (kPasses - 1);
        EXPECT_NEAR(direct_variance[i], direct, 1e-6 * direct);
    }
}

TEST(Film, AConstantPixelHasNoVarianceAndALargeOneKeepsIts) {
    const Size2 size{2, 1};
    Film film(size, LayerSet());
    for (uint32_t p = 0; p < 1000; ++p) {
        PassImage pass(size, LayerSet());
        pass.of<Layer::Direct>()[0] = Rgb(1.7f, 3e5f, 0.25f);
        pass.of<Layer::Direct>()[1] =
            Rgb(1e6f + static_cast<float>(p % 2), 0, 0);  // variance 1/4 (1000/999) at a mean of 1e6
        film.add_pass(pass);
    }
    const std::vector<float> variance = film.pass_variance_beauty();
    EXPECT_EQ(variance[0], 0.0f);
    EXPECT_EQ(variance[1], 0.0f);
    EXPECT_EQ(variance[2], 0.0f);
    EXPECT_NEAR(variance[3], 0.25 * 1000 / 999, 1e-6);
}

TEST(Film, SaturatedSquaresSayInfinityWhateverTheOrder) {
    const Size2 size{1, 1};
    const auto render = [&](const std::vector<float>& values) {
        Film film(size, LayerSet());
        for (const float value : values) {
            PassImage pass(size, LayerSet());
            pass.of<Layer::Direct>()[0] = Rgb(value);
            film.add_pass(pass);
        }
        return film;
    };
    std::vector<float> values(200, 0x1.fp28f);  // squares of 2^57.9 each: 69 of them pass 2^64
    values.push_back(1.0f);
    const Film film = render(values);
    std::reverse(values.begin(), values.end());
    EXPECT_TRUE(film == render(values));
    EXPECT_TRUE(std::isinf(film.pass_variance_beauty()[0]));
    EXPECT_TRUE(std::isfinite(film.resolve_beauty()[0]));
}

TEST(Film, BadValuesAreDroppedAndCounted) {
    const Size2 size{6, 1};
    LayerSet layers;
    layers.add(Layer::Albedo), layers.add(Layer::Depth);
    PassImage pass(size, layers);
    for (size_t i = 0; i < size.pixels(); ++i) {
        pass.of<Layer::Emitted>()[i] = Rgb(1), pass.hit[i] = 1, pass.of<Layer::Albedo>()[i] = Rgb(0.5f),
        pass.of<Layer::Depth>()[i] = 2;
    }
    pass.of<Layer::Direct>()[0].y = std::nanf("");
    pass.of<Layer::Direct>()[1] = Rgb(kInfinity, 0, std::nanf(""));  // a NaN counts as NaN whatever else is wrong
    pass.of<Layer::Indirect>()[2].z = -kInfinity;
    pass.of<Layer::Direct>()[3].x = kFilmValueLimit;
    pass.of<Layer::Albedo>()[4].x = kInfinity;
    Film film(size, layers);
    film.add_pass(pass);
    EXPECT_EQ(film.nan_count(), 2u);
    EXPECT_EQ(film.infinity_count(), 3u);
    const std::vector<float> beauty = film.resolve_beauty(), albedo = film.resolve(Layer::Albedo);
    const std::vector<float> depth = film.resolve(Layer::Depth);
    for (size_t i = 0; i < size.pixels(); ++i) {
        EXPECT_EQ(beauty[3 * i], i == 5 ? 1.0f : 0.0f) << i;
        EXPECT_EQ(albedo[3 * i], i == 5 ? 0.5f : 0.0f) << i;
        EXPECT_EQ(depth[i], i == 5 ? 2.0f : 0.0f) << i;
    }
}

TEST(PassImage, IsClearedInEveryLayerWhereItIsSaid) {
    const Size2 size{4, 3};
    PassImage image(size, LayerSet::all());
    size_t layers = 0;
    const auto fill = [&]<class Value>(const LayerInfo& info, std::vector<Value>& pixels) {
        EXPECT_EQ(pixels.size(), size.pixels()) << info.name;
        std::fill(pixels.begin(), pixels.end(), Value(2));
        ++layers;
    };
    image.each_layer(fill);
    EXPECT_EQ(layers, kLayerCount - 1) << "all but the standard error, which no pass has";
    std::fill(image.hit.begin(), image.hit.end(), uint8_t{1});
    image.clear(5, 2);
    image.each_layer([&]<class Value>(const LayerInfo& info, const std::vector<Value>& pixels) {
        for (size_t i = 0; i < pixels.size(); ++i)
            EXPECT_EQ(pixels[i], i == 5 || i == 6 ? Value(0) : Value(2)) << info.name << " " << i;
    });
    EXPECT_EQ(image.hit, (std::vector<uint8_t>{1, 1, 1, 1, 1, 0, 0, 1, 1, 1, 1, 1}));
}

TEST(PassImage, HoldsALayerOnlyWhereItIsAskedFor) {
    LayerSet layers;
    layers.add(Layer::Overlap);
    const PassImage image({2, 2}, layers);
    EXPECT_EQ(image.of<Layer::Overlap>(), std::vector<float>(4, 0.0f));
    EXPECT_EQ(image.of<Layer::Direct>(), std::vector<Rgb>(4, Rgb(0)));
    EXPECT_TRUE(image.of<Layer::Albedo>().empty() && image.of<Layer::Depth>().empty());
    EXPECT_EQ(image.hit.size(), 4u);
    EXPECT_TRUE(PassImage({2, 2}, LayerSet()).hit.empty()) << "no layer is divided by the samples that hit";
}

TEST(Film, AuxiliaryLayersAverageTheSamplesThatHit) {
    const Size2 size{2, 1};
    LayerSet layers;
    layers.add(Layer::Depth);
    Film film(size, layers);
    for (const float depth : {3.0f, 5.0f, 0.0f}) {
        PassImage pass(size, layers);
        pass.hit[0] = depth > 0, pass.of<Layer::Depth>()[0] = depth;
        film.add_pass(pass);
    }
    EXPECT_EQ(film.resolve(Layer::Depth), (std::vector<float>{4.0f, 0.0f}));
    EXPECT_EQ(film.resolve(Layer::Direct), std::vector<float>(6, 0.0f));
}

TEST(Film, PhotonsAreCountedOverTheSamplesThatHit) {
    const Size2 size{3, 1};
    LayerSet layers;
    layers.add(Layer::PhotonCount);
    EXPECT_EQ(Film::bytes_for(size, layers) - Film::bytes_for(size, LayerSet()),
              3 * (sizeof(FixedSum) + sizeof(uint32_t)));
    EXPECT_EQ(PassImage::bytes_for(size, layers) - PassImage::bytes_for(size, LayerSet()), 3 * (sizeof(float) + 1));
    Film film(size, layers);
    for (const float photons : {50.0f, 0.0f, 7.0f}) {
        PassImage pass(size, layers);
        pass.hit = {1, photons > 0, 0};  // no photon found is a count too; no surface met is none
        pass.of<Layer::PhotonCount>() = {photons, photons, 0};
        film.add_pass(pass);
    }
    EXPECT_EQ(film.resolve(Layer::PhotonCount), (std::vector<float>{19.0f, 28.5f, 0.0f}));
    EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
    PassImage bad(size, layers);
    bad.hit = {1, 1, 0};
    bad.of<Layer::PhotonCount>() = {std::numeric_limits<float>::quiet_NaN(), kFilmValueLimit, 0};
    film.add_pass(bad);
    EXPECT_EQ(film.nan_count(), 1u);
    EXPECT_EQ(film.infinity_count(), 1u);
    EXPECT_EQ(film.resolve(Layer::PhotonCount)[0], 19.0f);
}

TEST(Film, StandardErrorIsUnknownBeforeTheSecondPass) {
    LayerSet layers;
    layers.add(Layer::StandardError);
    Film film({1, 1}, layers);
    film.add_pass(PassImage({1, 1}, layers));
    EXPECT_TRUE(std::isinf(film.resolve(Layer::StandardError)[0]));
    film.add_pass(PassImage({1, 1}, layers));
    EXPECT_EQ(film.resolve(Layer::StandardError)[0], 0.0f);
}

}  // namespace
}  // namespace photond::film_test
