#pragma once
// Frames of an animation, each rendered from what the one before has left.

#include <memory>
#include <string>
#include <utility>

#include "tests/support/render.h"

namespace photond::test {

struct FrameOf {
    Film film;
    std::string left, state;
};

/// Passes of a frame by a method that has not begun; `state`: of the passes before; `pose`: of the frame before.
template <class M, class Settings>
FrameOf frame_after(M& method, const RenderContext& context, const Settings& settings, const std::string& before,
                    const std::string& state = {}, std::shared_ptr<const PastPose> pose = nullptr) {
    Stats stats;
    if (!before.empty()) method.follow({before, std::move(pose)});
    if (!state.empty()) method.go_on_from(state);
    method.begin(context, stats);
    Film film(settings.size, settings.layers, settings.first_pass);
    for (uint32_t i = 0; i < settings.passes; ++i) {
        method.run_pass(settings.first_pass + i, stats, CancelToken{});
        method.expect_pass(settings.first_pass + i + 1);  // as a job does; the last one comes to nothing
        method.resolve(film);
    }
    return {std::move(film), method.left_to_next(), method.state()};
}

/// Of a radiance cache whose cells age.
template <class M>
RenderSettingsOf<M> aged_settings(uint32_t passes) {
    RenderSettingsOf<M> settings;
    settings.size = {32, 24};
    settings.passes = passes;
    settings.params.aged = true;
    settings.params.cells = 1 << 14;
    return settings;
}

}  // namespace photond::test
