#pragma once
// A rig at a moment, and the scene that follows from it. What the scene is then follows from the rig and the moment
// alone, whatever it was before.

#include <optional>
#include <vector>

#include "renderer/scene/rig.h"

namespace photond {

/// A camera that hangs on a node of the walk.
struct PlacedCamera {
    std::string name;
    uint32_t node = 0;
    std::optional<uint32_t> index;  // in the scene's list; none while its node is scaled to nothing
    bool looks_at_rest = false;     // it is in that list at rest
};

/// What an animation makes of a rig's nodes, cameras, lights and materials, and where that puts its nodes.
struct PosedRig {
    std::vector<RigNode> nodes;
    std::vector<Camera> cameras;
    std::vector<RiggedLight> lights;
    std::vector<RiggedMaterial> materials;
    std::vector<dmat4> world;               // of each node
    std::vector<std::vector<dmat4>> skins;  // of each joint: its world matrix times its inverse bind matrix
    // Known once the scene is posed.
    std::vector<PlacedCamera> placed;  // in the walk's order
    std::optional<Bounds3> framing;    // what a camera is framed on where there is none: framing.h; none at rest

    uint64_t bytes() const;
    /// The camera of that name, the one that jobs without a name get where it is empty: the first of those that look at
    /// rest, so that it is the same at every moment. Null: there is none.
    const PlacedCamera* find(const std::string& name) const;
};

/// The rig at that moment. Throws ErrorCode::OutOfRange for an animation that it does not have.
PosedRig pose_rig(const Rig& rig, const Moment& moment);
/// What brings a mesh into the scene then, borrowed from `posed`. `origin`: the scene's.
MeshPose pose_of(const PosedRig& posed, uint32_t node, std::optional<uint32_t> skin, const dvec3& origin);
/// The cameras and lights that hang on nodes, in the walk's order, without those whose node is scaled to nothing. Gives
/// all cameras, and the nodes of the lights that are left out. Throws ErrorCode::BadScene, at the node, where a
/// transform is out of float's range.
std::vector<PlacedCamera> place_cameras(const Rig& rig, const PosedRig& posed, Scene& scene);
std::vector<uint32_t> place_lights(const Rig& rig, const PosedRig& posed, Scene& scene);
/// Whether each number of a transform is one in single precision too.
bool fits_float(const dmat4& m);

/// What is not as it was before a scene was posed.
struct SceneChange {
    std::vector<uint32_t> moved;     // meshes whose vertices moved and whose triangles are the same
    std::vector<uint32_t> reshaped;  // meshes that have other triangles
    bool materials = false;
};

/// Gives a scene what moves in it, and its rigged meshes, of which it has all but what pose_mesh() writes, their pose
/// at rest. It is to be finished then.
void adopt_rig(Scene& scene, std::shared_ptr<const Rig> rig);

/// Shows a finished scene at a moment: its meshes, instances, cameras, lights and materials, and what finish_scene()
/// derives. Only what lies otherwise than before is posed again. Throws ErrorCode::BadScene where a node moves a
/// vertex, a camera or a light out of float's range, and ErrorCode::OutOfRange for an animation that the scene does not
/// have; the scene is then fit for nothing but another pose.
SceneChange pose_scene(Scene& scene, const Moment& moment);

}  // namespace photond
