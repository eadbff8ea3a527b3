#pragma once
// A mesh as it is stored, in its node's space, and how morph targets, joints and nodes bring it into the scene.

#include <span>
#include <vector>

#include "renderer/scene/scene.h"

namespace photond {

/// One joint's influence on a vertex, as stored: a vertex's weights count by their share in their sum, which is not 0.
struct JointWeight {
    uint32_t joint = 0;
    float weight = 0;
};

/// What a morph target of weight 1 adds to each vertex. Empty: nothing.
struct MorphTarget {
    uint32_t weight = 0;  // which of a node's weights is its own
    std::vector<vec3> positions, normals, tangents;
};

struct ObjectMesh {
    Mesh mesh;                            // without its morph targets
    std::vector<MorphTarget> targets;     // without those that are nothing or never have a weight
    uint32_t joint_sets = 0;              // influences a vertex / 4
    std::vector<JointWeight> influences;  // 4 x joint_sets a vertex

    uint64_t bytes() const;
};

/// What brings a mesh into the scene: of a node, and of a skin that all its meshes share.
struct MeshPose {
    std::span<const double> weights;  // of the file's morph targets; of those past its end: 0
    std::span<const dmat4>
        transforms;   // of a skinned mesh a joint's world matrix times its inverse bind matrix; else one
    dvec3 origin{0};  // taken off every position
};

/// Writes positions, normals, tangents and triangles of `posed`, which may be the object's own mesh: in world space, by
/// double precision rounded once. Morph targets come first, then the joints, or the node where there are none (glTF
/// 2.0, 3.7.2.2 and 3.7.3.3). What mirrors a triangle turns its corners back, so that fronts stay fronts. Gives false
/// where a position is out of float's range.
bool pose_mesh(const ObjectMesh& object, const MeshPose& pose, Mesh& posed);

/// Gives the marked vertices the mean of their triangles' normals.
void replace_normals(Mesh& mesh, const std::vector<bool>& marked);

/// Drops triangles without area: two equal corners, or an area so small that no normal can be had in float. Gives their
/// number.
uint64_t drop_degenerate_triangles(Mesh& mesh);

}  // namespace photond
