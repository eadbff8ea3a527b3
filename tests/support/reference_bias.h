#pragma once
// The relative bias of the indirect layer's mean over regions of a picture, against a reference.

#include <gtest/gtest.h>

#include <array>

#include "tests/support/reference_images.h"
#include "tests/support/render.h"
#include "tests/support/statistics.h"

namespace photond::test {

/// The mean that is expected of the indirect layer, and what its bias is relative to.
struct Expected {
    std::vector<float> indirect;
    std::vector<float> relative_to;
};

/// Of one region's mean in one channel. `noise`: half-width of the interval outside of which the true bias lies with
/// the false-alarm rate asked for: Student's t over the films, and the reference's own noise.
struct RelativeBias {
    double value, standard_error, noise;
};

/// By region and channel. Pixels of a pass share its photons, so the noise is that of whole films' means. Films are of
/// consecutive ranges of `settings.passes` passes; low-discrepancy numbers spread them evenly among each other, which
/// makes the interval too wide if anything. `regions` hold masks of the picture's size; `expected` is of that size too.
template <class M>
std::vector<std::array<RelativeBias, 3>> relative_biases(const Scene& scene, RenderSettingsOf<M> settings,
                                                         uint32_t films, const Expected& expected,
                                                         const std::vector<Mask>& regions, double false_alarm) {
    std::vector<std::array<RunningMean, 3>> means(regions.size());
    for (uint32_t i = 0; i < films; ++i) {
        settings.first_pass = i * settings.passes;
        const Film film = render(scene, settings);
        EXPECT_EQ(film.nan_count() + film.infinity_count(), 0u);
        const std::vector<float> image = film.resolve(Layer::Indirect);
        for (size_t r = 0; r < regions.size(); ++r)
            for (size_t c = 0; c < 3; ++c) means[r][c].add(masked_mean(image, c, regions[r]));
    }
    std::vector<std::array<RelativeBias, 3>> biases(regions.size());
    for (size_t r = 0; r < regions.size(); ++r) {
        const double reference = reference_noise_of_mean(regions[r], settings.size.pixels());
        for (size_t c = 0; c < 3; ++c) {
            const double scale = masked_mean(expected.relative_to, c, regions[r]);
            const double error = means[r][c].standard_error();
            biases[r][c] = {
                (means[r][c].mean() - masked_mean(expected.indirect, c, regions[r])) / scale, error / scale,
                (two_sided_t(false_alarm, films - 1.0) * error + two_sided_z(false_alarm) * reference) / scale};
        }
    }
    return biases;
}

}  // namespace photond::test
