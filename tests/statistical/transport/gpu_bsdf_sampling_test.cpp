// What bsdf_sampling_test.cpp asks of the C++, asked of its GLSL twin: fewer draws and angles, as software devices take
// their time.

#include "tests/support/bsdf_sampling_checks.h"
#include "tests/support/gpu_bsdf.h"

namespace photond::gpu_bsdf_sampling_test {
namespace {

using namespace test;

constexpr double kFalseAlarm = 1e-6;  // of each test
constexpr CellGrid kGrid{12, 6, 28};

TEST(GpuBsdfSampling, DensitiesAndWeightsAreAsStated) {
    expect_densities_and_weights_as_stated(GpuBsdfs(), {.false_alarm = kFalseAlarm,
                                                        .draws = 60'000,
                                                        .grid = kGrid,
                                                        .roughnesses = {0.01f, 0.2f, 0.7f},
                                                        .cosines = {0.9999, 0.2}});
}

TEST(GpuBsdfSampling, ALobeThreePercentTooWideIsNoticed) {
    expect_lobes_three_percent_too_wide_are_noticed(GpuBsdfs(), 150'000, kGrid, {0.01f, 0.7f});
}

TEST(GpuBsdfSampling, DeltaLobesAreChosenAsOftenAsTheySay) {
    expect_delta_lobes_chosen_as_often_as_they_say(GpuBsdfs(), kFalseAlarm, 20'000, {0.9999, 0.7, 0.2});
}

}  // namespace
}  // namespace photond::gpu_bsdf_sampling_test
