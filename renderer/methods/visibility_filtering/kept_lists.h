#pragma once
// Lists of voxels that a frame of an animation takes over from those before: of each point that has a list, what the
// rays of its last frames met, so that the visibility filter sees more rays than a frame shoots. Rays whose way leads
// through what has moved are shot again, and whether the places that were met have light is asked anew: neither shadows
// nor light lag.
//
// Biased: what a list tells is what was seen from a place near by, as the visibility filter's lists are, frame by frame
// a little farther off.

#include <string>
#include <string_view>
#include <vector>

#include "renderer/frame/followed_frame.h"
#include "renderer/frame/frame_before.h"
#include "renderer/frame/render_context.h"
#include "renderer/methods/visibility_filtering/kept_lists_shared.h"
#include "renderer/methods/visibility_filtering/params.h"

namespace photond {

/// Whose lists they are: those of other images and other settings are none that a frame could take over.
struct KeptLayout {
    Size2 image, lists;
    uint32_t rays = 0;        // of a list
    uint32_t most_lists = 0;  // of a point

    KeptLayout() = default;
    KeptLayout(Size2 image_size, const VisibilityFilteringParams& params);
    uint64_t points() const { return lists.pixels(); }
    uint64_t places() const { return points() * most_lists * rays; }
    bool operator==(const KeptLayout&) const = default;
};

/// What a frame leaves.
struct LeftLists {
    KeptLayout layout;
    uint32_t turn = 0;  // ListsBetweenFrames::turn()
    gpu::CameraConstants camera{};
    std::vector<gpu::KeptPoint> points;
    std::vector<vec3> places;  // that were met (met_voxel.glsl): by point, list (the last frame's first) and ray

    LeftLists() = default;
    LeftLists(const KeptLayout& of, const gpu::CameraConstants& seen_by);
    std::string encode() const;
    /// Throws ErrorCode::Conflict unless they are of that layout.
    static LeftLists decode(std::string_view text, const KeptLayout& layout);
    static uint64_t bytes_for(const KeptLayout& layout);
};

/// What the method keeps from frame to frame. Does nothing unless the parameters ask for it.
class ListsBetweenFrames {
public:
    explicit ListsBetweenFrames(const VisibilityFilteringParams& params) : params_(params) {}
    static uint64_t bytes_for(const VisibilityFilteringParams& params, Size2 image);

    /// As those of Method, before begin(). The frame before's layout is asked by begin().
    void follow(const FrameBefore& before);
    void go_on_from(const std::string& state) const { followed_.go_on_from(state); }
    std::string state() const { return followed_.state(); }
    std::string left_to_next() const;

    /// Throws ErrorCode::Conflict where the frame before left lists of another image.
    void begin(const RenderContext& context);
    bool keeps() const { return params_.kept_lists > 0; }
    const LeftLists& before() const { return before_; }
    /// Boxes about what has moved since then, as it is and as it was.
    const std::vector<Bounds3>& moved() const { return moved_; }
    /// Frames that are neighbours and differ by it shoot other rays where rays are tied to the world: the lists that
    /// are kept and the frame's own are those of all turns, whichever frame it is.
    uint32_t turn() const { return turn_; }
    /// A pass is done: its points, what their own rays met, and what those of the lists that they have taken over meet
    /// now. The last one's is left.
    void leave(std::vector<gpu::TakingPoint> points, std::vector<vec3> met, std::vector<vec3> taken);

private:
    const VisibilityFilteringParams params_;
    FollowedFrame followed_;
    FrameBefore left_before_;  // until begin()
    LeftLists before_;
    std::vector<Bounds3> moved_;
    gpu::CameraConstants camera_{};
    uint32_t turn_ = 0;
    std::vector<gpu::TakingPoint> points_;
    std::vector<vec3> met_, taken_;  // by point, list and ray
};

}  // namespace photond
