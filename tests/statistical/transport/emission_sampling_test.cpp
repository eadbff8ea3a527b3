// The host's sampler of light paths' first step: emission_sampling_checks.h.

#include "tests/statistical/transport/emission_sampling_checks.h"

namespace photond::test::emission_sampling_test {
namespace {

INSTANTIATE_TYPED_TEST_SUITE_P(Host, EmissionFlux, HostEmission);
INSTANTIATE_TYPED_TEST_SUITE_P(Host, EmissionDirections, HostEmission);
INSTANTIATE_TYPED_TEST_SUITE_P(Host, EmissionAgreement, HostEmission);

TEST(EmissionSampler, EstimatesItsBytes) {
    const Scene scene = with_environment();
    const EmissionSampler sampler(scene);
    EXPECT_NEAR(static_cast<double>(sampler.bytes()),
                static_cast<double>(EmissionSampler::estimate_bytes(1, scene.environment->map.size)),
                0.1 * static_cast<double>(sampler.bytes()));
}

}  // namespace
}  // namespace photond::test::emission_sampling_test
