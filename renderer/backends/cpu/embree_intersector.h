#pragma once
#include <memory>

#include "renderer/core/stats.h"
#include "renderer/scene/intersector.h"

namespace photond {

struct SceneChange;

/// Builds the ray structure of a finished scene on the CPU, timed as stage `acceleration_build` and recorded in the
/// budget as `acceleration`. The scene is borrowed: it must outlive the intersector and not change.
/// Throws ErrorCode::OutOfMemory when the structure does not fit the budget; nothing of it is then left.
std::unique_ptr<Intersector> make_embree_intersector(const Scene& scene, MemoryBudget& budget, Stats& stats);

/// Brings what make_embree_intersector() made of a scene up to date after pose_scene() changed it, to the same answers
/// as what it would make now: what does not move is not built again where that takes longer than it saves. Timed and
/// recorded as there.
void follow_pose(std::unique_ptr<Intersector>& intersector, const Scene& scene, const SceneChange& change,
                 MemoryBudget& budget, Stats& stats);

/// What it will record, to some ten percent; builds nothing.
uint64_t estimate_acceleration_bytes(const Scene& scene);

}  // namespace photond
