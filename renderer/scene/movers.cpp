#include "renderer/scene/movers.h"

#include <set>

#include "protocol/error.h"

namespace photond {

namespace {

/// Counts for one animation after the other. What was counted for this one is marked with its number.
class MoverCount {
public:
    MoverCount(const Rig& rig, uint64_t max_moved)
        : rig_(rig),
          max_moved_(max_moved),
          parts_(rig.nodes.size()),
          nodes_of_camera_(rig.cameras.size()),
          nodes_of_light_(rig.lights.size()),
          meshes_of_skin_(rig.skins.size()),
          seen_skins_(rig.skins.size(), 0),
          seen_meshes_(rig.meshes.size(), 0) {
        for (uint32_t i = 0; i < rig.nodes.size(); ++i)
            if (rig.nodes[i].parent >= 0) parts_[static_cast<size_t>(rig.nodes[i].parent)].children.push_back(i);
        for (uint32_t m = 0; m < rig.meshes.size(); ++m) {
            const RiggedMesh& mesh = rig.meshes[m];
            parts_[mesh.node].meshes.push_back(m);
            if (mesh.skin) meshes_of_skin_[*mesh.skin].push_back(m);
        }
        for (uint32_t s = 0; s < rig.skins.size(); ++s)
            for (const uint32_t joint : rig.skins[s].joints)
                if (!meshes_of_skin_[s].empty()) parts_[joint].skins.push_back(s);
        for (const uint32_t i : rig.walk) {
            parts_[i].shown = true;
            if (const int32_t camera = rig.nodes[i].camera; camera >= 0)
                nodes_of_camera_[static_cast<size_t>(camera)].push_back(i);
            if (const int32_t light = rig.nodes[i].light; light >= 0)
                nodes_of_light_[static_cast<size_t>(light)].push_back(i);
        }
    }

    Movers count(const Animation& animation) {
        ++number_;
        movers_ = {};
        std::set<uint32_t> materials;
        for (const Channel& channel : animation.channels)
            for (const uint32_t target : channel.targets) {
                if (channel.property <= Property::Scale)
                    move_node(target);
                else if (channel.property == Property::Weights)
                    for (const uint32_t mesh : parts_[target].meshes) count_mesh(mesh);
                else if (channel.property <= Property::YMag)
                    for (const uint32_t node : nodes_of_camera_[target]) count_camera(node);
                else if (channel.property <= Property::OuterCone)
                    for (const uint32_t node : nodes_of_light_[target]) count_light(node);
                else
                    materials.insert(target);
            }
        movers_.materials = static_cast<uint32_t>(materials.size());
        return movers_;
    }

private:
    /// What hangs on a node. The marks are numbers of animations.
    struct Parts {
        std::vector<uint32_t> children, meshes;
        std::vector<uint32_t> skins;  // that move a mesh and have it as a joint
        bool shown = false;           // the scene has it
        uint32_t moved = 0, counted_camera = 0, counted_light = 0;
    };

    void step() {
        if (++moved_ > max_moved_)
            throw Error(
                ErrorCode::BadScene, "/animations",
                "all animations together move more than " + std::to_string(max_moved_) + " nodes, meshes and joints");
    }

    /// With all below it.
    void move_node(uint32_t target) {
        std::vector<uint32_t> open = {target};
        while (!open.empty()) {
            const uint32_t i = open.back();
            open.pop_back();
            step();
            Parts& parts = parts_[i];
            if (parts.moved == number_) continue;
            parts.moved = number_;
            for (const uint32_t mesh : parts.meshes)
                if (!rig_.meshes[mesh].skin) count_mesh(mesh);
            for (const uint32_t skin : parts.skins) move_skin(skin);
            count_camera(i), count_light(i);
            open.insert(open.end(), parts.children.begin(), parts.children.end());
        }
    }
    void move_skin(uint32_t skin) {
        step();
        if (seen_skins_[skin] == number_) return;
        seen_skins_[skin] = number_;
        for (const uint32_t mesh : meshes_of_skin_[skin]) count_mesh(mesh);
    }
    void count_mesh(uint32_t mesh) {
        step();
        if (seen_meshes_[mesh] == number_) return;
        seen_meshes_[mesh] = number_;
        ++movers_.meshes;
        movers_.triangles += rig_.meshes[mesh].object->mesh.triangles.size();
    }
    void count_camera(uint32_t node) {
        step();
        Parts& parts = parts_[node];
        if (!parts.shown || rig_.nodes[node].camera < 0 || parts.counted_camera == number_) return;
        parts.counted_camera = number_;
        ++movers_.cameras;
    }
    void count_light(uint32_t node) {
        Parts& parts = parts_[node];
        if (!parts.shown || rig_.nodes[node].light < 0 || parts.counted_light == number_) return;
        parts.counted_light = number_;
        ++movers_.lights;
    }

    const Rig& rig_;
    const uint64_t max_moved_;
    std::vector<Parts> parts_;  // of each node
    std::vector<std::vector<uint32_t>> nodes_of_camera_, nodes_of_light_;
    std::vector<std::vector<uint32_t>> meshes_of_skin_;
    std::vector<uint32_t> seen_skins_, seen_meshes_;
    uint32_t number_ = 0;
    uint64_t moved_ = 0;
    Movers movers_;
};

}  // namespace

std::vector<Movers> count_movers(const Rig& rig, uint64_t max_moved) {
    MoverCount count(rig, max_moved);
    std::vector<Movers> movers;
    for (const Animation& animation : rig.animations) movers.push_back(count.count(animation));
    return movers;
}

}  // namespace photond
