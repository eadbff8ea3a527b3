#include "renderer/scene/framing.h"

#include "renderer/scene/pose.h"

namespace photond {

Bounds3 framing_bounds(const Scene& scene, const Rig& rig, uint32_t index) {
    const Animation& animation = rig.animations[index];
    const Movement moving = movement_of(rig, {&animation, 1});
    std::vector<bool> rigged(scene.meshes.size());
    for (const RiggedMesh& mesh : rig.meshes) rigged[mesh.mesh] = true;
    Bounds3 bounds;
    for (const Instance& instance : scene.instances) {
        if (rigged[instance.mesh]) continue;
        for (const vec3& p : scene.meshes[instance.mesh].positions)
            bounds.extend(instance.identity ? p : instance.to_world * vec4(p, 1));
    }
    Mesh posed_mesh;
    for (int k = -1; k < kFramedMoments; ++k) {  // -1: at rest
        Moment moment;
        if (k >= 0) moment = {index, animation.duration_s() * k / (kFramedMoments - 1)};
        const PosedRig posed = pose_rig(rig, moment);
        for (const RiggedMesh& mesh : rig.meshes) {
            if (k >= 0 && !moving.moves_mesh(mesh.node, mesh.skin)) continue;
            // What is out of float's range at that moment is refused when the moment is asked for.
            if (!pose_mesh(*mesh.object, pose_of(posed, mesh.node, mesh.skin, scene.origin), posed_mesh)) continue;
            for (const vec3& p : posed_mesh.positions) bounds.extend(p);
        }
    }
    return bounds;
}

}  // namespace photond
