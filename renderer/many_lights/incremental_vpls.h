#pragma once
// Virtual point lights that a frame of an animation takes over from the one before: paths whose first surface the same
// place of the same lamp still sees stay where they are on it, wherever it has moved, and at most so many a frame are
// new. All passes of a frame have the same lights. [Laine et al. 2007]
//
// A path counts as much as the share of the lights' flux about it. Shares are measured along the curve through the
// lights' map (photons/texel_map.h): a path is as far along it as the flux is that the map reflects before it, and has
// the half of the way to each of its neighbours; whatever is dropped, the rest has all of the flux. New paths go where
// the ways are longest, and where lights are crowded some make room. In place of the paper's Voronoi cells of a light's
// directions, this serves all kinds of lights at once, and goes by what is reflected instead of what is sent.
//
// Biased: a path stands for all of its share as if that were lit and coloured as it is. The bias stays the same as
// long as the lights do, so that it does not flicker.
//
// [Laine et al. 2007] Incremental Instant Radiosity for Real-Time Indirect Illumination. EGSR.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/frame/followed_frame.h"
#include "renderer/frame/frame_before.h"
#include "renderer/frame/render_context.h"
#include "renderer/many_lights/vpl_params.h"
#include "renderer/many_lights/vpl_tracer.h"

namespace photond {

/// A light path as a frame leaves it.
struct LeftVplPath {
    uint32_t slot;   // of its random numbers after the first hit
    uint32_t light;  // index as in EmissionSampler
    vec2 u_position, u_direction;
    uint32_t instance, triangle;  // of its first hit
    vec2 barycentrics;
};

/// What a frame leaves.
struct LeftVplPaths {
    uint32_t slots = 0;   // paths that there is room for
    uint32_t lights = 0;  // of the scene
    uint64_t seed = 0;    // of the first frame's numbers, which all go on with
    std::vector<LeftVplPath> paths;

    std::string encode() const;
    /// Throws ErrorCode::Conflict unless they are of as many slots.
    static LeftVplPaths decode(std::string_view text, uint32_t slots);
};

/// What a method keeps from frame to frame. Does nothing unless the parameters ask for it.
class VplsBetweenFrames {
public:
    /// `slots`: paths of a frame.
    VplsBetweenFrames(const IncrementalVplParams& params, uint32_t slots);
    /// Of the host's memory.
    static uint64_t bytes_for(const IncrementalVplParams& params, uint32_t slots);

    /// As those of Method.
    void follow(FrameBefore before);
    void go_on_from(const std::string& state) const { followed_.go_on_from(state); }
    std::string state() const { return followed_.state(); }
    std::string left_to_next() const { return left_; }

    bool on() const { return params_.on; }
    /// In begin(), where they are on and something is lit: chooses the frame's paths. The tracer is of as many paths.
    /// Stages `rsm` and `vpl_generation`; counts those kept and new. Takes `vpls_between_frames` of the host's budget.
    void renew(const VplTracer& tracer, const EmissionSampler& emission, const RenderContext& context, Stats& stats);
    /// After that: the paths of each pass and the seed of their numbers.
    const ChosenPaths& paths() const { return paths_; }
    uint64_t seed() const { return seed_; }

private:
    const IncrementalVplParams params_;
    const uint32_t slots_;
    FrameBefore before_;
    LeftVplPaths left_before_;
    FollowedFrame followed_;
    std::string left_;
    ChosenPaths paths_;
    uint64_t seed_ = 0;
};

}  // namespace photond
