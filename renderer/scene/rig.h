#pragma once
// What of a scene moves: nodes, joints, morph targets, cameras, lights and materials as they are at rest, and the
// animations that change them. Shared by all moments of a scene; pose.h makes one.

#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/scene/keyframes.h"
#include "renderer/scene/object_mesh.h"

namespace photond {

/// Of a mesh's morph targets. Shared by nodes that take them from the same mesh, or from the same keys; null: none.
using MorphWeights = std::shared_ptr<const std::vector<double>>;

struct RigNode {
    std::string name;     // which its camera and its light take
    int32_t parent = -1;  // none where negative
    int32_t camera = -1;  // likewise, of the rig
    int32_t light = -1;   // likewise
    dvec3 translation{0};
    glm::dquat rotation{1, 0, 0, 0};  // unit
    dvec3 scale{1};
    std::optional<dmat4> matrix;  // instead of these three; then no animation moves the node
    MorphWeights weights;

    dmat4 local() const;
};

struct RigSkin {
    std::vector<uint32_t> joints;     // nodes
    std::vector<dmat4> inverse_bind;  // of each joint
};

/// A mesh that is posed: it has one instance, in world space.
struct RiggedMesh {
    std::shared_ptr<const ObjectMesh> object;
    uint32_t node = 0;
    std::optional<uint32_t> skin;
    uint32_t mesh = 0;  // of the scene
    /// Glass, at some moment: solids that touch are made to overlap, in which either may be changed, so each is posed
    /// whenever one is.
    bool transmits = false;
};

/// A light before nodes place it.
struct RiggedLight {
    std::string name;
    PunctualLight::Kind kind = PunctualLight::Kind::Point;
    dvec3 color{1};
    double intensity = 1;
    double range_m = std::numeric_limits<double>::infinity();
    double inner_cone = 0, outer_cone = 0.7853981633974483;  // half-angles [rad]
};

/// KHR_texture_transform.
struct TextureTransform {
    dvec3 offset{0}, scale{1};  // two numbers each
    double rotation = 0;        // [rad]

    void apply(TextureRef& reference) const;
};

/// Textures of a material, in visit_texture_refs()'s order.
inline constexpr uint32_t kTextureSlots = 7;

/// A material that an animation changes.
struct RiggedMaterial {
    uint32_t material = 0;  // of the scene
    Material rest;
    dvec3 emissive_factor{0};
    double emissive_strength = 1;
    TextureTransform transforms[kTextureSlots];
};

/// What an animation changes, of the rig's node, camera, light or material.
enum class Property : uint8_t {
    Translation,
    Rotation,
    Scale,
    Weights,
    YFov,
    YMag,
    LightColor,
    LightIntensity,
    LightRange,
    InnerCone,
    OuterCone,
    BaseColor,
    Metallic,
    Roughness,
    NormalScale,
    EmissiveFactor,
    EmissiveStrength,
    AlphaCutoff,
    Ior,
    Specular,
    SpecularColor,
    Transmission,
    AttenuationColor,
    AttenuationDistance,
    TextureOffset,
    TextureScale,
    TextureRotation,
};

struct Channel {
    Property property = Property::Translation;
    uint32_t slot = 0;                           // of a texture's transform
    std::vector<uint32_t> targets;               // which all get the same
    std::shared_ptr<const Keyframes> keyframes;  // shared by channels that a file gives the same keys
};

struct Animation {
    std::string name;
    std::vector<Channel> channels;  // a later one wins

    /// Seconds of the last key of all.
    double duration_s() const;
};

struct Rig {
    std::vector<RigNode> nodes;
    std::vector<uint32_t> order;  // of the nodes, parents before their children
    std::vector<RigSkin> skins;
    std::vector<RiggedMesh> meshes;
    std::vector<Camera> cameras;  // before nodes place them
    std::vector<RiggedLight> lights;
    std::vector<RiggedMaterial> materials;
    std::vector<Animation> animations;
    std::vector<uint32_t> walk;  // nodes of the scene, in the order in which its cameras and lights are listed

    uint64_t bytes() const;
};

/// What some animations move.
struct Movement {
    std::vector<bool> nodes;    // their place, by their parents' movement too
    std::vector<bool> weights;  // of nodes: those of their morph targets
    std::vector<bool> skins;    // the place of any of their joints

    /// Whether what a node shows moves: by its place, or by that of the skin's joints, or by morph targets.
    bool moves_mesh(uint32_t node, std::optional<uint32_t> skin) const {
        return weights[node] || (skin ? skins[*skin] : nodes[node]);
    }
};
Movement movement_of(const Rig& rig, std::span<const Animation> animations);

/// What nodes hold, weights that they share once.
uint64_t node_bytes(const std::vector<RigNode>& nodes);

/// An order for the nodes of a forest: parents before their children.
std::vector<uint32_t> parents_first(const std::vector<RigNode>& nodes);

}  // namespace photond
