// Every lobe and mixture of lobes is sampled with the density it states (chi-square over half-vectors), and the weights
// of the samples average to the integral of what evaluate() returns.

#include "tests/support/bsdf_sampling_checks.h"

namespace photond::bsdf_sampling_test {
namespace {

using namespace test;

constexpr double kFalseAlarm = 1e-6;  // of each test
constexpr size_t kDraws = 150'000;
constexpr CellGrid kGrid{18, 10, 28};

TEST(BsdfSampling, DensitiesAndWeightsAreAsStated) {
    expect_densities_and_weights_as_stated(CpuBsdfs(), {.false_alarm = kFalseAlarm,
                                                        .draws = kDraws,
                                                        .grid = kGrid,
                                                        .roughnesses = {0.01f, 0.05f, 0.2f, 0.5f, 1.0f},
                                                        .cosines = {0.9999, 0.7, 0.2, 0.02}});
}

TEST(BsdfSampling, ALobeThreePercentTooWideIsNoticed) {
    expect_lobes_three_percent_too_wide_are_noticed(CpuBsdfs(), kDraws, kGrid, {0.01f, 0.2f, 0.7f});
}

TEST(BsdfSampling, DeltaLobesAreChosenAsOftenAsTheySay) {
    expect_delta_lobes_chosen_as_often_as_they_say(CpuBsdfs(), kFalseAlarm, 100'000, {0.9999, 0.7, 0.2, 0.02});
}

}  // namespace
}  // namespace photond::bsdf_sampling_test
