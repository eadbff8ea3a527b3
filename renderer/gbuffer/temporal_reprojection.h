#pragma once
// Temporal reprojection: a method whose frames of an animation take over what the last ones knew of indirect light.

#include "renderer/frame/common_params.h"
#include "renderer/frame/method.h"
#include "renderer/gbuffer/history.h"

namespace photond {

/// Renders as the method it holds does, and averages the indirect layer of each pass with what the frames before knew
/// of the same points of the same surfaces (reprojection.h), as far as the light there has not changed
/// (light_change.h): a pixel of n frames counts its own light as 1 / n, n at most TemporalParams::history_cap [Knecht
/// et al. 2010, Differential Instant Radiosity for Mixed Reality, 5; Yang et al. 2020, A Survey of Temporal
/// Antialiasing Techniques, 3]. Biased: light that changes slowly lags, and what is seen from another place blurs by
/// up to a pixel a frame. Emitted and direct light, and the caustic layer, are the pass's own; so is `standard_error`,
/// which tells of this frame's part alone.
///
/// Passes are pure functions of their index and of the frame before. The method within may have a state of its own and
/// leave something to the next frame: those come before what is this class's.
class TemporalReprojection final : public Method {
public:
    TemporalReprojection(std::unique_ptr<Method> method, const TemporalParams& params);
    ~TemporalReprojection() override;

    void follow(FrameBefore before) override;
    void go_on_from(const std::string& state) override;
    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    void expect_pass(uint32_t pass) override { method_->expect_pass(pass); }
    void settle() override { method_->settle(); }
    PassImage* end_pass() override;
    std::string state() const override;
    std::string left_to_next() const override;
    std::vector<MethodArtefact> artefacts() const override { return method_->artefacts(); }

    /// What it takes of the host's memory beside the method within.
    static uint64_t estimate_bytes(Size2 size);
    /// And of a device's, where its rays are traced there.
    static uint64_t estimate_device_bytes(Size2 size) { return size.pixels() * (sizeof(Ray) + sizeof(Hit)); }

private:
    struct Frame;

    const std::unique_ptr<Method> method_;
    const uint32_t history_cap_;
    FrameBefore before_;
    std::string followed_ = std::string(64, '-');  // SHA-256 of what the frame before left
    std::string state_before_;
    std::unique_ptr<Frame> frame_;  // once begun
};

}  // namespace photond
