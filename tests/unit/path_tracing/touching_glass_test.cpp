// Blocks of glass that share a face, in uniform light: radiance over the square of the index is the same along a path
// without loss, so they cannot be seen.

#include <gtest/gtest.h>

#include "renderer/scene/builtin_scenes.h"
#include "tests/support/path_render.h"
#include "tests/support/statistics.h"

namespace photond::touching_glass_test {
namespace {

constexpr double kFalseAlarm = 1e-6;

TEST(TouchingGlass, IsInvisibleInUniformLight) {
    // Where the second of two faces was stepped over, 9.8 % were missing.
    const Scene scene = make_builtin_scene("hard-case/touching-dielectrics");
    const auto radiance = [&](uint64_t seed) {
        test::RenderSettings settings;
        settings.passes = 8, settings.seed = seed;
        return test::mean_of(test::render(scene, settings).resolve_beauty());
    };
    const test::Interval interval = test::mean_interval(test::replicates(12, radiance), kFalseAlarm, 1);
    EXPECT_LE(std::abs(interval.mean - 1), interval.half_width);
    EXPECT_LE(interval.half_width, 0.03) << "too noisy to see a face that is missed";
}

}  // namespace
}  // namespace photond::touching_glass_test
