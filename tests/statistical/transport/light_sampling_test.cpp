// The host's sampler of lights: light_sampling_checks.h.

#include "tests/statistical/transport/light_sampling_checks.h"

namespace photond::test::light_sampling_test {
namespace {

INSTANTIATE_TYPED_TEST_SUITE_P(Host, LightSamplingDensity, HostLights);
INSTANTIATE_TYPED_TEST_SUITE_P(Host, LightSamplingEstimate, HostLights);

}  // namespace
}  // namespace photond::test::light_sampling_test
