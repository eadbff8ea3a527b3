#include "renderer/frame/device_method.h"

#include "renderer/frame/device_frame.h"

namespace photond {

void DeviceMethod::expect_pass(uint32_t pass) { frame().expect_pass(pass); }
void DeviceMethod::settle() { frame().settle(); }
PassImage* DeviceMethod::end_pass() { return frame().end_pass(); }

}  // namespace photond
