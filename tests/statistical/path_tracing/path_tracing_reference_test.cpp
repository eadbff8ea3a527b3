// Path tracing against images of the diffuse Cornell box made by an independent renderer (tests/data/reference).
//
// Blocks of 8x8 pixels: z = (mean - reference) / sigma, sigma^2 = between-pass variance / passes of the block's mean +
// (noise of the reference)^2 / 64 + (1e-4 of the value)^2; the limit on |z| is Sidak's over all blocks, channels and
// images. The long run finds a defect of 0.1 % in an image's mean; the short one, with less than a fifth of the
// signal to noise, one of 2 %.

#include <gtest/gtest.h>

#include "renderer/scene/builtin_scenes.h"
#include "tests/support/path_render.h"
#include "tests/support/reference_images.h"
#include "tests/support/statistics.h"

namespace photond::path_tracing_reference_test {
namespace {

constexpr Size2 kSize{256, 256};
constexpr double kFalseAlarm = 1e-6;
constexpr size_t kBlock = 8, kBlocks = 256 / kBlock, kImages = 3;
constexpr double kBiasLimit = 1e-3;  // per channel, relative

struct Image {
    std::vector<float> mean, pass_variance;
};

/// Whether the pixel or one beside it shows the lamp, but not all of them alike: cut by the emitter's edge.
bool at_emitter_edge(const std::vector<float>& reference, size_t x, size_t y) {
    constexpr float kLamp = 3;  // [W m^-2 sr^-1] in red; everything else in the box is far below, the lamp is 17
    bool lit = false, unlit = false;
    for (size_t j = y == 0 ? 0 : y - 1; j <= std::min<size_t>(y + 1, 255); ++j)
        for (size_t i = x == 0 ? 0 : x - 1; i <= std::min<size_t>(x + 1, 255); ++i)
            (reference[3 * (j * 256 + i)] > kLamp ? lit : unlit) = true;
    return lit && unlit;
}

/// `noise`: RMSE of the reference. `exact_bias`: the long run, whose means must lie within the bias allowed; the short
/// run's own noise is allowed beside it.
void expect_agrees(const Image& image, const char* file, double noise, uint32_t passes, bool exact_bias) {
    SCOPED_TRACE(file);
    const std::vector<float> reference = test::reference_image(file);
    ASSERT_EQ(reference.size(), image.mean.size());
    const double z_limit = test::two_sided_z(test::share_of_false_alarm(kFalseAlarm, kImages * 3 * kBlocks * kBlocks));
    ASSERT_LT(z_limit, 6.5);

    double worst = 0, sum_of_squares = 0;
    for (size_t c = 0; c < 3; ++c) {
        double total = 0, reference_total = 0, variance_total = 0;
        for (size_t by = 0; by < kBlocks; ++by) {
            for (size_t bx = 0; bx < kBlocks; ++bx) {
                double mean = 0, expected = 0, variance = 0;
                for (size_t y = by * kBlock; y < (by + 1) * kBlock; ++y) {
                    for (size_t x = bx * kBlock; x < (bx + 1) * kBlock; ++x) {
                        const size_t i = 3 * (y * 256 + x) + c;
                        total += image.mean[i], reference_total += reference[i];
                        // Samples have all missed (or all met) the lamp's sliver of the pixel: nothing tells how often.
                        if (image.pass_variance[i] == 0 && at_emitter_edge(reference, x, y)) continue;
                        mean += image.mean[i];
                        expected += reference[i];
                        variance += image.pass_variance[i];
                        // No light at all may mean that no path has found the rim of a penumbra: the block judges it.
                        const bool settled = image.pass_variance[i] == 0 && image.mean[i] > 0;
                        if (settled) {
                            EXPECT_LE(std::abs(image.mean[i] - reference[i]), 1e-3 * reference[i])
                                << "pixel " << x << ", " << y << " channel " << c;
                        }
                    }
                }
                variance_total += variance;
                constexpr double kPixels = kBlock * kBlock;
                mean /= kPixels, expected /= kPixels;
                const double sigma = std::sqrt(variance / (kPixels * kPixels) / passes + noise * noise / kPixels +
                                               1e-8 * expected * expected);
                const double z = (mean - expected) / sigma;
                if (std::abs(z) > z_limit)
                    ADD_FAILURE() << "block " << bx << ", " << by << " channel " << c << ": mean " << mean
                                  << ", reference " << expected << ", sigma " << sigma;
                worst = std::max(worst, std::abs(z));
                sum_of_squares += z * z;
            }
        }
        const double bias = total / reference_total - 1;
        const double standard_error = std::sqrt(variance_total / passes) / reference_total;
        std::printf("%s channel %zu: relative bias %+.5f %%, standard error %.5f %%\n", file, c, 100 * bias,
                    100 * standard_error);
        const double noise_allowance =
            exact_bias ? 0 : test::two_sided_z(test::share_of_false_alarm(kFalseAlarm, kImages * 3)) * standard_error;
        EXPECT_LE(std::abs(bias), kBiasLimit + noise_allowance);
        EXPECT_LE(noise_allowance, 20 * kBiasLimit) << "too noisy to notice a defect";
    }
    std::printf("%s: worst |z| %.2f of %.2f, mean z^2 %.3f\n", file, worst, z_limit,
                sum_of_squares / (3 * kBlocks * kBlocks));
    EXPECT_LT(worst, z_limit);
}

void compare_with_reference(uint32_t passes, bool exact_bias) {
    const Scene scene = make_builtin_scene("cornell-box");
    test::RenderSettings settings;
    settings.size = kSize;
    settings.passes = passes;
    const auto beauty = [&](std::optional<uint32_t> bounces) {
        settings.params.indirect_bounces = bounces;
        const Film film = test::render(scene, settings);
        EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
        return Image{film.resolve_beauty(), film.pass_variance_beauty()};
    };
    expect_agrees(beauty({}), "reference_256.exr", test::kReferenceNoise, passes, exact_bias);
    expect_agrees(beauty(0), "direct_only_256.exr", 8e-5, passes, exact_bias);
    settings.params.indirect_bounces = 1;
    const Film film = test::render(scene, settings);
    // Its noise is not stated; that of the full image, which holds this light, is taken.
    expect_agrees({film.resolve(Layer::Indirect), film.pass_variance(Layer::Indirect)}, "indirect_one_bounce_256.exr",
                  test::kReferenceNoise, passes, exact_bias);
}

TEST(PathTracingReference, AgreesWithAnIndependentRenderer) { compare_with_reference(32, false); }

TEST(PathTracingReferenceLong, AgreesWithAnIndependentRenderer) { compare_with_reference(1024, true); }

}  // namespace
}  // namespace photond::path_tracing_reference_test
