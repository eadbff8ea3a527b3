#include "renderer/scene/pose.h"

#include <algorithm>
#include <map>
#include <utility>

#include "protocol/error.h"
#include "renderer/scene/framing.h"

namespace photond {

namespace {

vec3 unit_direction(const dvec3& v, const vec3& otherwise) {
    const double length = glm::length(v);
    return length > 0 && std::isfinite(length) ? vec3(v / length) : otherwise;
}

constexpr double kMost = double{std::numeric_limits<float>::max()}, kLeast = double{std::numeric_limits<float>::min()};

float fitted(double value, double least, double most) { return static_cast<float>(std::clamp(value, least, most)); }
float not_negative(double value) { return fitted(value, 0, kMost); }
Rgb color_of(const double* rgb) { return {not_negative(rgb[0]), not_negative(rgb[1]), not_negative(rgb[2])}; }
dvec3 vector_of(const double* numbers) { return {numbers[0], numbers[1], numbers[2]}; }

/// What lies between keys can be out of the range that keys are in: a spline overshoots. It ends at the range.
void set_material(RiggedMaterial& rigged, const Channel& channel, const double* value) {
    Material& m = rigged.rest;
    TextureTransform& transform = rigged.transforms[channel.slot];
    switch (channel.property) {
        case Property::BaseColor:
            for (int k = 0; k < 3; ++k) m.base_color[k] = fitted(value[k], 0, 1);
            m.alpha = fitted(value[3], 0, 1);
            break;
        case Property::Metallic: m.metallic = fitted(*value, 0, 1); break;
        case Property::Roughness: m.roughness = fitted(*value, 0, 1); break;
        case Property::NormalScale: m.normal_scale = fitted(*value, -kMost, kMost); break;
        case Property::EmissiveFactor: rigged.emissive_factor = vector_of(value); break;
        case Property::EmissiveStrength: rigged.emissive_strength = *value; break;
        case Property::AlphaCutoff: m.alpha_cutoff = not_negative(*value); break;
        case Property::Ior: m.ior = m.ior == 0 ? 0 : fitted(*value, 1, kMost); break;
        case Property::Specular: m.specular = fitted(*value, 0, 1); break;
        case Property::SpecularColor: m.specular_color = color_of(value); break;
        case Property::Transmission: m.transmission = fitted(*value, 0, 1); break;
        case Property::AttenuationColor: m.attenuation_color = glm::min(color_of(value), Rgb(1)); break;
        case Property::AttenuationDistance: m.attenuation_distance = fitted(*value, kLeast, kMost); break;
        case Property::TextureOffset: transform.offset = {value[0], value[1], 0}; break;
        case Property::TextureScale: transform.scale = {value[0], value[1], 0}; break;
        case Property::TextureRotation: transform.rotation = *value; break;
        default: break;
    }
}

void set_light(RiggedLight& light, Property property, const double* value) {
    constexpr double kHalfPi = 1.5707963267948966;
    switch (property) {
        case Property::LightColor: light.color = glm::max(vector_of(value), dvec3(0)); break;
        case Property::LightIntensity: light.intensity = std::max(*value, 0.0); break;
        case Property::LightRange: light.range_m = std::clamp(*value, kLeast, kMost); break;
        case Property::InnerCone: light.inner_cone = std::clamp(*value, 0.0, kHalfPi); break;
        case Property::OuterCone: light.outer_cone = std::clamp(*value, 0.0, kHalfPi); break;
        default: break;
    }
}

void set_node(RigNode& node, Property property, const double* value) {
    switch (property) {
        case Property::Translation: node.translation = vector_of(value); break;
        case Property::Rotation: node.rotation = {value[3], value[0], value[1], value[2]}; break;
        case Property::Scale: node.scale = vector_of(value); break;
        default: break;
    }
}

void set_camera(Camera& camera, Property property, double value) {
    constexpr double kLeastView = 1e-6, kMostFov = 3.141592;
    if (property == Property::YFov) camera.yfov = fitted(value, kLeastView, kMostFov);
    if (property == Property::YMag) camera.ymag = fitted(std::fabs(value), kLeastView, kMost);
}

/// Weights that keys give, which may be many and for many nodes: those of the same keys are evaluated once.
using EvaluatedWeights = std::map<const Keyframes*, MorphWeights>;

void apply_weights(const Channel& channel, double time_s, EvaluatedWeights& evaluated, PosedRig& posed) {
    MorphWeights& weights = evaluated[channel.keyframes.get()];
    if (!weights) {
        std::vector<double> values(channel.keyframes->width);
        channel.keyframes->evaluate(time_s, values.data());
        weights = std::make_shared<const std::vector<double>>(std::move(values));
    }
    for (const uint32_t target : channel.targets) posed.nodes[target].weights = weights;
}

void apply(const Channel& channel, double time_s, PosedRig& posed) {
    std::vector<double> value(channel.keyframes->width);
    channel.keyframes->evaluate(time_s, value.data());
    for (const uint32_t target : channel.targets) {
        if (channel.property <= Property::Scale)
            set_node(posed.nodes[target], channel.property, value.data());
        else if (channel.property <= Property::YMag)
            set_camera(posed.cameras[target], channel.property, value.front());
        else if (channel.property <= Property::OuterCone)
            set_light(posed.lights[target], channel.property, value.data());
        else
            set_material(posed.materials[target], channel, value.data());
    }
}

Material material_of(const RiggedMaterial& rigged) {
    Material material = rigged.rest;
    // Two finite factors may have an infinite product, which the loader refuses of a material at rest.
    material.emission = glm::min(color_of(&rigged.emissive_factor.x) * not_negative(rigged.emissive_strength),
                                 Rgb(std::numeric_limits<float>::max()));
    uint32_t slot = 0;
    visit_texture_refs(material, [&](TextureRef& reference) { rigged.transforms[slot++].apply(reference); });
    return material;
}

PunctualLight light_of(const RiggedLight& rigged) {
    PunctualLight light;
    light.name = rigged.name;
    light.kind = rigged.kind;
    const dvec3 intensity = rigged.color * rigged.intensity;
    light.intensity = color_of(&intensity.x);
    light.range_m = static_cast<float>(rigged.range_m);
    if (light.kind == PunctualLight::Kind::Spot) {
        light.cos_inner = static_cast<float>(std::cos(std::min(rigged.inner_cone, rigged.outer_cone)));
        light.cos_outer = static_cast<float>(std::max(0.0, std::cos(rigged.outer_cone)));
    }
    return light;
}

void require_fit(const PosedRig& posed, uint32_t node, const char* what) {
    if (!fits_float(posed.world[node]))
        throw Error(
            ErrorCode::BadScene, "/nodes/" + std::to_string(node),
            "the node's transform, with its parents', moves its " + std::string(what) + " out of float's range");
}

/// Its orientation and place; false where the node's axes say none.
bool place_camera(Camera& camera, const dmat4& m, const dvec3& origin) {
    // The axes are made orthonormal: scale does not act on a camera.
    const dvec3 back(m[2]), up(m[1]), right = glm::cross(up, back);
    if (!(glm::length(back) > 0) || !(glm::length(right) > 1e-9 * glm::length(up) * glm::length(back))) return false;
    camera.forward = vec3(-glm::normalize(back));
    camera.right = vec3(glm::normalize(right));
    camera.up = vec3(glm::normalize(glm::cross(back, right)));
    camera.position = vec3(dvec3(m[3]) - origin);
    return true;
}

/// Which meshes lie otherwise than before. What many of them share is compared once.
class Difference {
public:
    /// `before`: how the meshes lay; null: not known.
    Difference(const PosedRig* before, const PosedRig& now) : before_(before), now_(now) {
        for (size_t k = 0; before && k < now.skins.size(); ++k) skins_.push_back(before->skins[k] != now.skins[k]);
    }
    bool operator()(const RiggedMesh& mesh) {
        if (!before_) return true;
        if (weights_differ(before_->nodes[mesh.node].weights, now_.nodes[mesh.node].weights)) return true;
        return mesh.skin ? skins_[*mesh.skin] : before_->world[mesh.node] != now_.world[mesh.node];
    }

private:
    bool weights_differ(const MorphWeights& before, const MorphWeights& now) {
        if (before == now) return false;
        const auto [known, is_new] = weights_.try_emplace({before.get(), now.get()}, true);
        if (is_new) known->second = !before || !now || *before != *now;
        return known->second;
    }

    const PosedRig* before_;
    const PosedRig& now_;
    std::vector<bool> skins_;
    std::map<std::pair<const std::vector<double>*, const std::vector<double>*>, bool> weights_;
};

/// `before`: how the meshes lay; null: not known.
void pose_meshes(Scene& scene, const PosedRig* before, const PosedRig& now, SceneChange& change) {
    const Rig& rig = *scene.rig;
    Difference differs(before, now);
    std::vector<bool> moved;
    for (const RiggedMesh& mesh : rig.meshes) moved.push_back(differs(mesh));
    // Solids that touch were changed together, and are made anew together.
    bool glass_moved = false;
    for (size_t k = 0; k < rig.meshes.size(); ++k) glass_moved |= rig.meshes[k].transmits && moved[k];
    const auto is_glass = [](const RiggedMaterial& material) { return material.rest.transmission > 0; };
    for (size_t m = 0; before && m < now.materials.size(); ++m)
        glass_moved |= is_glass(before->materials[m]) != is_glass(now.materials[m]);
    for (size_t k = 0; k < rig.meshes.size(); ++k) {
        const RiggedMesh& rigged = rig.meshes[k];
        if (!moved[k] && !(glass_moved && rigged.transmits)) continue;
        Mesh& mesh = scene.meshes[rigged.mesh];
        const std::vector<uvec3> triangles = mesh.triangles;
        if (!pose_mesh(*rigged.object, pose_of(now, rigged.node, rigged.skin, scene.origin), mesh))
            throw Error(ErrorCode::BadScene, "/nodes/" + std::to_string(rigged.node),
                        "the node's transform moves a vertex out of float's range");
        drop_degenerate_triangles(mesh);
        (mesh.triangles == triangles ? change.moved : change.reshaped).push_back(rigged.mesh);
    }
}

void note_looks_at_rest(const Rig& rig, const PosedRig* before, const Moment& moment,
                        std::vector<PlacedCamera>& placed) {
    Scene at_rest;
    std::vector<PlacedCamera> known;
    if (before)
        known = before->placed;
    else if (moment.animation)
        known = place_cameras(rig, pose_rig(rig, {}), at_rest);
    for (size_t c = 0; c < placed.size(); ++c)
        placed[c].looks_at_rest = before             ? known[c].looks_at_rest
                                  : moment.animation ? known[c].index.has_value()
                                                     : placed[c].index.has_value();
}

/// All of a pose but what finish_scene() derives.
SceneChange show(Scene& scene, const Moment& moment) {
    const Rig& rig = *scene.rig;
    SceneChange change;
    PosedRig posed = pose_rig(rig, moment);
    const std::shared_ptr<const PosedRig> before = std::exchange(scene.posed, nullptr);
    pose_meshes(scene, before.get(), posed, change);
    posed.placed = place_cameras(rig, posed, scene);
    note_looks_at_rest(rig, before.get(), moment, posed.placed);
    if (moment.animation && posed.find("") == nullptr) {
        const bool known = before && before->framing && scene.moment.animation == moment.animation;
        posed.framing = known ? before->framing : framing_bounds(scene, rig, *moment.animation);
    }
    place_lights(rig, posed, scene);
    for (const RiggedMaterial& rigged : posed.materials) scene.materials[rigged.material] = material_of(rigged);
    change.materials = !posed.materials.empty();
    scene.posed = std::make_shared<const PosedRig>(std::move(posed));
    scene.moment = moment;
    return change;
}

}  // namespace

PosedRig pose_rig(const Rig& rig, const Moment& moment) {
    PosedRig posed{rig.nodes, rig.cameras, rig.lights, rig.materials, {}, {}};
    if (moment.animation) {
        if (*moment.animation >= rig.animations.size())
            throw Error(ErrorCode::OutOfRange, "/animation",
                        "the scene has " + std::to_string(rig.animations.size()) + " animations");
        EvaluatedWeights weights;
        for (const Channel& channel : rig.animations[*moment.animation].channels) {
            if (channel.property == Property::Weights)
                apply_weights(channel, moment.time_s, weights, posed);
            else
                apply(channel, moment.time_s, posed);
        }
    }
    posed.world.resize(rig.nodes.size());
    for (const uint32_t i : rig.order) {
        const RigNode& node = posed.nodes[i];
        const dmat4 local = node.local();
        posed.world[i] = node.parent < 0 ? local : posed.world[static_cast<size_t>(node.parent)] * local;
    }
    posed.skins.resize(rig.skins.size());
    for (size_t s = 0; s < rig.skins.size(); ++s) {
        const RigSkin& skin = rig.skins[s];
        posed.skins[s].resize(skin.joints.size());
        for (size_t k = 0; k < skin.joints.size(); ++k)
            posed.skins[s][k] = posed.world[skin.joints[k]] * skin.inverse_bind[k];
    }
    return posed;
}

MeshPose pose_of(const PosedRig& posed, uint32_t node, std::optional<uint32_t> skin, const dvec3& origin) {
    MeshPose pose{.weights = {}, .transforms = {&posed.world[node], 1}, .origin = origin};
    if (const MorphWeights& weights = posed.nodes[node].weights) pose.weights = *weights;
    if (skin) pose.transforms = posed.skins[*skin];
    return pose;
}

uint64_t PosedRig::bytes() const {
    uint64_t bytes = node_bytes(nodes) + materials.capacity() * sizeof(RiggedMaterial) +
                     world.capacity() * sizeof(dmat4) + skins.capacity() * sizeof(std::vector<dmat4>) +
                     placed.capacity() * sizeof(PlacedCamera);
    for (const std::vector<dmat4>& skin : skins) bytes += skin.capacity() * sizeof(dmat4);
    return bytes;
}

const PlacedCamera* PosedRig::find(const std::string& name) const {
    const PlacedCamera* found = nullptr;
    for (const PlacedCamera& camera : placed) {
        if (!name.empty() && camera.name != name) continue;
        if (camera.looks_at_rest) return &camera;
        if (!name.empty() && !found) found = &camera;
    }
    return found;
}

bool fits_float(const dmat4& m) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!(std::fabs(m[column][row]) <= kMost)) return false;
    return true;
}

std::vector<PlacedCamera> place_cameras(const Rig& rig, const PosedRig& posed, Scene& scene) {
    std::vector<PlacedCamera> placed;
    scene.cameras.clear();
    for (const uint32_t i : rig.walk) {
        const RigNode& node = rig.nodes[i];
        if (node.camera < 0) continue;
        require_fit(posed, i, "camera");
        Camera camera = posed.cameras[static_cast<size_t>(node.camera)];
        if (!node.name.empty()) camera.name = node.name;
        if (camera.name.empty()) camera.name = "camera_" + std::to_string(placed.size());
        placed.push_back({.name = camera.name, .node = i});
        if (!place_camera(camera, posed.world[i], scene.origin)) continue;
        placed.back().index = static_cast<uint32_t>(scene.cameras.size());
        scene.cameras.push_back(std::move(camera));
    }
    return placed;
}

std::vector<uint32_t> place_lights(const Rig& rig, const PosedRig& posed, Scene& scene) {
    std::vector<uint32_t> left_out;
    scene.punctual_lights.clear();
    for (const uint32_t i : rig.walk) {
        const RigNode& node = rig.nodes[i];
        if (node.light < 0) continue;
        require_fit(posed, i, "light");
        PunctualLight light = light_of(posed.lights[static_cast<size_t>(node.light)]);
        const dvec3 back(posed.world[i][2]);
        if (light.kind != PunctualLight::Kind::Point && !(glm::length(back) > 0)) {
            left_out.push_back(i);
            continue;
        }
        light.position = vec3(dvec3(posed.world[i][3]) - scene.origin);
        light.direction = unit_direction(-back, vec3(0, 0, -1));
        if (!node.name.empty()) light.name = node.name;
        scene.punctual_lights.push_back(std::move(light));
    }
    return left_out;
}

void adopt_rig(Scene& scene, std::shared_ptr<const Rig> rig) {
    scene.rig = std::move(rig);
    scene.posed = nullptr;
    show(scene, {});
}

SceneChange pose_scene(Scene& scene, const Moment& moment) {
    if (!scene.rig) {
        if (moment.animation) throw Error(ErrorCode::OutOfRange, "/animation", "nothing in the scene is animated");
        return {};
    }
    if (scene.posed && scene.moment == moment) return {};
    SceneChange change = show(scene, moment);
    finish_again(scene, change.materials || !change.reshaped.empty());
    return change;
}

}  // namespace photond
