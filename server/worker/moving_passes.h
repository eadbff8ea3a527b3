#pragma once
// A job with an open shutter: each pass shows the scene at a moment of its own, one for all its rays and photons.

#include <optional>

#include "renderer/frame/method.h"

namespace photond {

/// When within the shutter's time a pass is, 0 to 1: moments of any number of passes one after the other lie evenly.
/// They follow multiples of the golden ratio, which keep no step with the powers of two by which samples within passes
/// are laid out: in step with these a pixel would see each part of its own area at one time alone.
double shutter_share(uint64_t seed, uint32_t pass);

/// A method made anew for every pass, of a scene that is posed for it. Its passes must stand alone
/// (MethodInfo::passes_stand_alone).
class MovingPasses final : public Method {
public:
    struct Job {
        std::function<std::unique_ptr<Method>()> make;
        /// Poses the scene; gives what a method is told of it then.
        std::function<RenderContext(double time_s, Stats& stats)> show;
        double open_s = 0, shutter_s = 0;
        uint64_t seed = 1;
    };
    explicit MovingPasses(Job job) : job_(std::move(job)) {}

    void begin(const RenderContext& context, Stats& stats) override;
    void run_pass(uint32_t pass, Stats& stats, const CancelToken& cancel) override;
    PassImage* end_pass() override { return method_->end_pass(); }
    std::vector<MethodArtefact> artefacts() const override { return method_->artefacts(); }

private:
    const Job job_;
    std::optional<RenderContext> context_;  // of the pass at hand
    std::unique_ptr<Method> method_;        // likewise
};

}  // namespace photond
