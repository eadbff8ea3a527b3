#pragma once
// Where last frame's image showed what this one shows [Scherzer et al. 2007, Pixel-Correct Shadow Maps with Temporal
// Reprojection; Knecht et al. 2010, Differential Instant Radiosity for Mixed Reality].

#include "renderer/core/cancel.h"
#include "renderer/frame/render_context.h"
#include "renderer/gbuffer/history.h"
#include "renderer/scene/intersector.h"
#include "renderer/scene/past_pose.h"

namespace photond {

/// Why a pixel takes over nothing.
enum class Rejection : uint8_t {
    None,
    Surface,  // what it shows was not there, was hidden, or lets no light be taken over
    Outside,  // it was outside of the last frame's image
};

/// What the pixels' middles show, and the history there.
struct Reprojected {
    History now;   // of this frame: camera, positions, normals, instances; the rest is for who renders it
    History past;  // at this frame's pixels; frames are 0 where there is none
    std::vector<Rejection> rejection;  // a pixel

    static uint64_t bytes_for(Size2 size) { return 2 * History::bytes_for(size) + size.pixels(); }
};

/// Begins to trace a ray through the middle of each pixel and of the lens: the hits that reproject() takes.
std::unique_ptr<HitsToCome> begin_centre_hits(const RenderContext& context);

/// Takes the `hits` of rays through the pixels' middles, one a pixel, row by row. The point that each found is followed
/// back to where it was (`pose`; null: nothing has moved but what has a rig, of which nothing is known) and looked up
/// in `before` between four pixels, of which those count whose surface is the same: the same instance, normals at most
/// 25 degrees apart, and on its plane within a hundredth of the distance to the eye. Mirrors and glass show what lies
/// elsewhere: nothing is taken over there. `before` null: there is no frame before. Parallel; the same for any number
/// of threads.
Reprojected reproject(const Scene& scene, const View& view, std::span<const Hit> hits, const History* before,
                      const PastPose* pose);

}  // namespace photond
