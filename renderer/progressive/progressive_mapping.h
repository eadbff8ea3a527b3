#pragma once
// What the progressive photon mapping methods have in common: a pass sends photons, looks from the eye, and estimates
// the light of the maps at the visible points, on discs whose radii shrink from pass to pass (disc_radii.h).
//
//   L_r = int f L_l cos            light samples; what f's specular part f_s scatters is joined with followed paths by
//                                  multiple importance sampling
//       + int f_s (L - L_l) cos    the eye path goes on by sampling f_s
//       + int f_d (L - L_l) cos    the caustic map and the global map, on discs of their own radii
//
// f_s are delta lobes and glossy ones with alpha below `glossy_threshold`, f_d all others. Each map has its own radii:
// caustics are sharp and bright where the rest is smooth.

#include <memory>

#include "renderer/frame/method.h"
#include "renderer/progressive/progressive_params.h"

namespace photond {

class ProgressiveMapping : public Method {
public:
    /// `eye_passes`: passes whose numbers the eye's paths repeat, so that hit points are fixed; 0: new ones each pass.
    ProgressiveMapping(std::unique_ptr<const ProgressiveParams> params, uint32_t eye_passes);
    ~ProgressiveMapping() override;

    void go_on_from(const std::string& state) override;
    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    PassImage* end_pass() override;
    std::string state() const override;

protected:
    static uint64_t estimate_bytes(const ProgressiveParams& params, uint32_t eye_passes, const Workload& workload);
    static uint64_t estimate_state_bytes(const ProgressiveParams& params, uint32_t eye_passes,
                                         const Workload& workload);

private:
    struct State;

    const std::unique_ptr<const ProgressiveParams> params_;
    const uint32_t eye_passes_;
    std::string state_before_;
    std::unique_ptr<State> state_;
};

}  // namespace photond
