#pragma once
#include "renderer/frame/method.h"

namespace photond {

class DeviceFrame;

/// A method whose passes a device frame takes to the film: begin() makes the frame, run_pass() runs it.
class DeviceMethod : public Method {
public:
    void expect_pass(uint32_t pass) override;
    void settle() override;
    PassImage* end_pass() override;

private:
    /// Asked after begin() only.
    virtual DeviceFrame& frame() = 0;
};

}  // namespace photond
