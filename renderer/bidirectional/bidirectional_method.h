#pragma once
// What the bidirectional methods have in common: a pass sends light paths through the scene, keeps their vertices and
// what the camera sees of them, then follows a path from the eye through each pixel, and joins it with them in every
// way there is. mis_weights.h says how the ways are weighed.

#include <memory>

#include "renderer/bidirectional/bidirectional_params.h"
#include "renderer/frame/method.h"

namespace photond {

class BidirectionalMethod : public Method {
public:
    explicit BidirectionalMethod(std::unique_ptr<const BidirectionalParams> params);
    ~BidirectionalMethod() override;

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    PassImage* end_pass() override;

protected:
    static uint64_t estimate_bytes(const BidirectionalParams& params, const Workload& workload);

private:
    struct State;

    const std::unique_ptr<const BidirectionalParams> params_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
