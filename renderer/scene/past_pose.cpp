#include "renderer/scene/past_pose.h"

#include "renderer/scene/rig.h"

namespace photond {

PastPose::PastPose(const Scene& scene) {
    if (!scene.rig) return;
    for (const RiggedMesh& rigged : scene.rig->meshes) {
        const Mesh& mesh = scene.meshes[rigged.mesh];
        meshes_[rigged.mesh] = {mesh.positions, mesh.triangles};
    }
}

std::optional<TriangleCorners> PastPose::triangle(const Scene& now, uint32_t instance, uint32_t triangle) const {
    const uint32_t index = now.instances[instance].mesh;
    const auto found = meshes_.find(index);
    if (found == meshes_.end()) return world_triangle(now, instance, triangle);
    const Vertices& past = found->second;
    const uvec3 corners = now.meshes[index].triangles[triangle];
    if (triangle >= past.triangles.size() || past.triangles[triangle] != corners) return std::nullopt;
    return TriangleCorners{{past.positions[corners.x], past.positions[corners.y], past.positions[corners.z]}};
}

std::vector<Bounds3> PastPose::moved_bounds(const Scene& now) const {
    std::vector<Bounds3> moved;
    const auto add_box = [&](const std::vector<vec3>& positions) {
        Bounds3 box;
        for (const vec3& p : positions) box.extend(p);
        if (!box.empty()) moved.push_back(box);
    };
    for (const auto& [index, past] : meshes_) {
        const Mesh& mesh = now.meshes[index];
        if (past.positions == mesh.positions && past.triangles == mesh.triangles) continue;
        add_box(mesh.positions);
        add_box(past.positions);
    }
    return moved;
}

uint64_t PastPose::bytes() const {
    uint64_t bytes = 0;
    for (const auto& [index, past] : meshes_)
        bytes += past.positions.capacity() * sizeof(vec3) + past.triangles.capacity() * sizeof(uvec3);
    return bytes;
}

}  // namespace photond
