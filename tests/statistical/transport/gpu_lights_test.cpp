// The device's samplers of lights: what the host's have to pass.

#include "tests/statistical/transport/emission_sampling_checks.h"
#include "tests/statistical/transport/light_sampling_checks.h"
#include "tests/support/device_light_samples.h"

namespace photond::test::gpu_lights_test {
namespace {

INSTANTIATE_TYPED_TEST_SUITE_P(Device, LightSamplingDensity, DeviceLights);
INSTANTIATE_TYPED_TEST_SUITE_P(Device, LightSamplingEstimate, DeviceLights);
INSTANTIATE_TYPED_TEST_SUITE_P(Device, EmissionFlux, DeviceEmission);
INSTANTIATE_TYPED_TEST_SUITE_P(Device, EmissionDirections, DeviceEmission);
INSTANTIATE_TYPED_TEST_SUITE_P(Device, EmissionAgreement, DeviceEmission);

}  // namespace
}  // namespace photond::test::gpu_lights_test
