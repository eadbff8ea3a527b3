#include "renderer/scene/gltf_placement.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "renderer/scene/gltf_mesh.h"
#include "renderer/scene/gltf_rig.h"
#include "renderer/scene/rig_builder.h"

namespace photond {

namespace {

/// Below this many triangles in all copies, copies in world space cost less than the ray tracer's second level.
constexpr uint64_t kMaxBakedCopyTriangles = 1000;
/// Scenes farther out than this many of their radii are re-centred.
constexpr double kFarRadii = 16;

using dmat3 = glm::dmat3;
using dvec4 = glm::dvec4;

struct Bounds {
    dvec3 min{std::numeric_limits<double>::infinity()};
    dvec3 max{-std::numeric_limits<double>::infinity()};
    void extend(const dvec3& p) { min = glm::min(min, p), max = glm::max(max, p); }
};

/// A mesh as read, and nodes that show it in the same shape.
struct PlacedMesh {
    std::shared_ptr<ObjectMesh> object;  // which others may hold too
    std::vector<uint32_t> nodes;
    std::optional<uint32_t> skin;  // then there is one node
};

/// What decides what is read of a mesh for a node.
struct MeshReading {
    int mesh;
    size_t joints;     // 0 where the node has no skin
    uint32_t targets;  // of Placement::target_lists_

    bool operator<(const MeshReading& other) const {
        return std::tuple(mesh, joints, targets) < std::tuple(other.mesh, other.joints, other.targets);
    }
};

Instance placed_instance(uint32_t mesh, const dmat4& to_world, const dvec3& origin) {
    Instance instance;
    instance.mesh = mesh;
    instance.identity = false;
    dmat4 moved = to_world;
    moved[3] -= dvec4(origin, 0);
    instance.to_world = mat4x3(mat4(moved));
    const dmat3 linear(to_world);
    instance.normal_to_world = mat3(glm::transpose(glm::inverse(linear)));
    instance.flips_orientation = glm::determinant(linear) < 0;
    return instance;
}

class Placement {
public:
    Placement(const GltfDocument& document, GltfData& data, const LoadLimits& limits, Scene& scene)
        : document_(document), model_(document.model), data_(data), limits_(limits), scene_(scene) {}

    /// Gives what moves; null: nothing.
    std::shared_ptr<Rig> run() {
        *rig_ = read_gltf_rig(document_, data_, warnings_);
        rest_ = pose_rig(*rig_, {});
        moving_ = movement_of(*rig_, rig_->animations);
        find_animated_materials();
        check_transforms();
        check_triangle_count();
        read_meshes();
        check_joints();
        choose_origin();
        for (PlacedMesh& placed : meshes_) place(placed);
        for (const PlacedCamera& camera : place_cameras(*rig_, rest_, scene_))
            if (!camera.index) note_scaled_to_nothing("camera", camera.node);
        for (const uint32_t node : place_lights(*rig_, rest_, scene_)) note_scaled_to_nothing("light", node);
        warn();
        if (rig_->animations.empty()) return nullptr;
        count_scene_materials();
        return rig_;
    }

private:
    void find_animated_materials() {
        for (const Animation& animation : rig_->animations)
            for (const Channel& channel : animation.channels)
                if (channel.property >= Property::BaseColor) {
                    animated_materials_.insert(channel.targets.begin(), channel.targets.end());
                    if (channel.property == Property::Transmission)
                        becoming_glass_.insert(channel.targets.begin(), channel.targets.end());
                }
    }

    /// Channels of materials count the rig's from now on; those of materials that nothing has are dropped.
    void count_scene_materials() {
        std::map<uint32_t, uint32_t> rigged;  // by the document's index
        for (const uint32_t index : animated_materials_) {
            const auto used = material_of_.find(static_cast<int>(index));
            if (used == material_of_.end()) continue;
            rigged.emplace(index, static_cast<uint32_t>(rig_->materials.size()));
            rig_->materials.push_back(read_rigged_material(model_.materials[index]));
            rig_->materials.back().material = used->second;
        }
        for (Animation& animation : rig_->animations)
            std::erase_if(animation.channels, [&](Channel& channel) {
                if (channel.property < Property::BaseColor) return false;
                const auto found = rigged.find(channel.targets.front());
                if (found != rigged.end()) channel.targets = {found->second};
                return found == rigged.end();
            });
    }

    void check_transforms() const {
        for (const uint32_t i : rig_->walk) {
            const RigNode& node = rig_->nodes[i];
            if ((model_.nodes[i].mesh >= 0 || node.camera >= 0 || node.light >= 0) && !fits_float(rest_.world[i]))
                throw Error(ErrorCode::BadScene, gltf_pointer("nodes", i),
                            "the node's transform, with its parents', is not finite in single precision");
        }
    }

    void check_triangle_count() const {
        uint64_t total = 0;
        for (const uint32_t i : rig_->walk) {
            if (model_.nodes[i].mesh < 0) continue;
            for (const tinygltf::Primitive& primitive : model_.meshes[model_.nodes[i].mesh].primitives)
                total += promised_triangles(primitive, model_);
            if (total > limits_.max_triangles)
                throw Error(ErrorCode::BadScene, gltf_pointer("nodes", i, "mesh"),
                            "up to this node the scene has " + std::to_string(total) +
                                " triangles, more than the limit of " + std::to_string(limits_.max_triangles));
        }
    }

    void read_meshes() {
        // Nodes that show the same mesh in the same shape are a range of meshes_; those of other shapes share what is
        // read of it where that is the same.
        std::map<int, std::pair<size_t, size_t>> shared;
        std::map<MeshReading, std::vector<std::shared_ptr<ObjectMesh>>> read;
        for (const uint32_t i : rig_->walk) {
            const tinygltf::Node& node = model_.nodes[i];
            if (node.mesh < 0) continue;
            const bool own_shape = node.skin >= 0 || !node.weights.empty() || moving_.weights[i];
            if (const auto found = shared.find(node.mesh); found != shared.end() && !own_shape) {
                for (size_t k = found->second.first; k < found->second.second; ++k) meshes_[k].nodes.push_back(i);
                continue;
            }
            std::optional<uint32_t> skin;
            if (node.skin >= 0) skin = static_cast<uint32_t>(node.skin);
            const MeshReading reading{node.mesh, skin ? rig_->skins[*skin].joints.size() : 0, target_list_of(i)};
            const auto [found, is_new] = read.try_emplace(reading);
            if (is_new) found->second = read_mesh(reading);
            const size_t first = meshes_.size();
            for (const std::shared_ptr<ObjectMesh>& object : found->second) {
                if (skin && object->joint_sets == 0)
                    throw Error(ErrorCode::BadScene, gltf_pointer("nodes", i, "skin"),
                                "the mesh has no JOINTS_0 and WEIGHTS_0");
                meshes_.push_back({object, {i}, skin});
            }
            if (!own_shape) shared.emplace(node.mesh, std::pair{first, meshes_.size()});
        }
    }

    /// Which of its mesh's morph targets matter to a node, as an index into target_lists_: all where an animation gives
    /// them weights, else those that have one.
    uint32_t target_list_of(uint32_t node) {
        const std::vector<tinygltf::Primitive>& primitives = model_.meshes[model_.nodes[node].mesh].primitives;
        const auto count = static_cast<uint32_t>(primitives.front().targets.size());
        const MorphWeights& weights = rig_->nodes[node].weights;
        const bool all = moving_.weights[node];
        const auto [known, is_new] = known_lists_.try_emplace({all ? nullptr : weights.get(), all ? count : 0});
        if (!is_new) return known->second;
        std::vector<uint32_t> list;
        for (uint32_t k = 0; k < count; ++k)
            if (all || (weights && (*weights)[k] != 0)) list.push_back(k);
        const auto [found, unlike] =
            target_lists_.try_emplace(std::move(list), static_cast<uint32_t>(by_index_.size()));
        if (unlike) by_index_.push_back(&found->first);
        return known->second = found->second;
    }

    std::vector<std::shared_ptr<ObjectMesh>> read_mesh(const MeshReading& reading) {
        std::vector<std::shared_ptr<ObjectMesh>> objects;
        const tinygltf::Mesh& mesh = model_.meshes[reading.mesh];
        const std::vector<uint32_t>& targets = *by_index_[reading.targets];
        for (uint32_t p = 0; p < mesh.primitives.size(); ++p) {
            const tinygltf::Primitive& primitive = mesh.primitives[p];
            const auto positions = gltf_attribute(primitive, "POSITION");
            if (!positions) continue;
            if (primitive.mode < 4) {
                ++tally_.points_and_lines;
                continue;
            }
            // Where the first primitive has no positions, others may have fewer targets than it.
            const auto end = std::ranges::lower_bound(targets, primitive.targets.size());
            const MeshShape shape{reading.joints, {targets.begin(), end}};
            if (is_one_point(primitive, *positions, shape.targets) ||
                (primitive.indices >= 0 && is_zeros(primitive.indices))) {
                tally_.degenerate_triangles += promised_triangles(primitive, model_);
                continue;
            }
            const uint32_t material = use_material(primitive.material);
            const auto object = std::make_shared<ObjectMesh>(read_primitive_mesh(
                document_, data_, static_cast<uint32_t>(reading.mesh), p, shape, wants_of(material), tally_));
            if (object->mesh.triangles.empty()) continue;
            object->mesh.material = material;
            objects.push_back(object);
        }
        return objects;
    }

    /// An accessor of nothing but zeros: one point, or one corner, again and again.
    bool is_zeros(int accessor) const {
        return model_.accessors[accessor].bufferView < 0 && !model_.accessors[accessor].sparse.isSparse;
    }
    /// Positions that are all zeros, and that no morph target moves apart.
    bool is_one_point(const tinygltf::Primitive& primitive, int positions, std::span<const uint32_t> targets) const {
        return is_zeros(positions) && std::ranges::all_of(targets, [&](uint32_t k) {
                   const auto moved = primitive.targets[k].find("POSITION");
                   return moved == primitive.targets[k].end() || is_zeros(moved->second);
               });
    }

    /// The scene's index of a document's material, entered when it is used for the first time.
    uint32_t use_material(int index) {
        const auto [found, is_new] = material_of_.try_emplace(index, static_cast<uint32_t>(scene_.materials.size()));
        if (!is_new) return found->second;
        const bool animated = animated_materials_.contains(static_cast<uint32_t>(index));
        Material material = index < 0 ? Material{} : read_gltf_material(model_.materials[index], animated);
        if (index < 0) material.name = "default";
        visit_texture_refs(material, [&](TextureRef& reference) {
            if (reference.used() && !has_source(model_.textures[reference.texture])) reference = {};
        });
        UvSlots slots;
        visit_texture_refs(material, [&](TextureRef& reference) {
            if (reference.used() && reference.uv_set < 2) slots.set[reference.uv_set] = reference.uv_set;
        });
        visit_texture_refs(material, [&](TextureRef& reference) {
            if (!reference.used()) return;
            int slot = 0;
            while (slot < 2 && slots.set[slot] && *slots.set[slot] != reference.uv_set) ++slot;
            if (reference.uv_set < 2) slot = static_cast<int>(reference.uv_set);
            if (slot == 2)
                throw Error(ErrorCode::Unsupported, gltf_pointer("materials", index),
                            "reads more than two sets of texture coordinates");
            slots.set[slot] = reference.uv_set;
            reference.uv_set = static_cast<uint32_t>(slot);
        });
        if (material.transmission > 0 || (index >= 0 && becoming_glass_.contains(static_cast<uint32_t>(index))))
            ever_glass_.insert(found->second);
        scene_.materials.push_back(std::move(material));
        uv_slots_.push_back(slots);
        return found->second;
    }

    MeshWants wants_of(uint32_t material) const {
        MeshWants wants;
        wants.uv = uv_slots_[material];
        const TextureRef& normal = scene_.materials[material].normal_texture;
        if (normal.used()) wants.normal_texture = &normal;
        return wants;
    }

    MeshPose rest_pose(uint32_t node, std::optional<uint32_t> skin) const {
        return pose_of(rest_, node, skin, scene_.origin);
    }

    void check_joints() const {
        std::set<uint32_t> checked;
        for (const PlacedMesh& placed : meshes_) {
            if (!placed.skin || !checked.insert(*placed.skin).second) continue;
            const std::vector<dmat4>& transforms = rest_.skins[*placed.skin];
            for (size_t k = 0; k < transforms.size(); ++k)
                if (!fits_float(transforms[k]))
                    throw Error(ErrorCode::BadScene, gltf_pointer("skins", *placed.skin, "joints", std::to_string(k)),
                                "the joint's transform is not finite");
        }
    }

    /// What may bring a vertex of the mesh into the scene: the node, or each joint that has a weight.
    std::vector<dmat4> transforms_of(const PlacedMesh& placed) const {
        std::vector<dmat4> transforms;
        if (!placed.skin) {
            for (const uint32_t node : placed.nodes) transforms.push_back(rest_.world[node]);
            return transforms;
        }
        std::vector<uint32_t> joints;
        for (const JointWeight& influence : placed.object->influences)
            if (influence.weight > 0) joints.push_back(influence.joint);
        std::ranges::sort(joints);
        joints.erase(std::unique(joints.begin(), joints.end()), joints.end());
        for (const uint32_t joint : joints) transforms.push_back(rest_.skins[*placed.skin][joint]);
        return transforms;
    }

    /// A box around the scene from boxes around its meshes: as good as needed to tell where it lies.
    void choose_origin() {
        Bounds bounds;
        for (const PlacedMesh& placed : meshes_) {
            Bounds object;
            for (const vec3& p : placed.object->mesh.positions) object.extend(dvec3(p));
            for (const dmat4& m : transforms_of(placed))
                for (int corner = 0; corner < 8; ++corner)
                    bounds.extend(dvec3(m * dvec4(corner & 1 ? object.min.x : object.max.x,
                                                  corner & 2 ? object.min.y : object.max.y,
                                                  corner & 4 ? object.min.z : object.max.z, 1)));
        }
        const dvec3 centre = 0.5 * (bounds.min + bounds.max);
        const double radius = 0.5 * glm::length(bounds.max - bounds.min);
        if (!(radius > 0) || !std::isfinite(radius) || !(glm::length(centre) > kFarRadii * radius)) return;
        // A multiple of a power of two near the radius: subtracting it leaves short numbers short.
        const double unit = std::exp2(std::floor(std::log2(radius)));
        scene_.origin = glm::round(centre / unit) * unit;
    }

    /// What moves, and glass that what moves may come to touch, is the rig's.
    void place(PlacedMesh& placed) {
        const bool glass = !rig_->animations.empty() && ever_glass_.contains(placed.object->mesh.material);
        std::vector<uint32_t> rigged, still;
        for (const uint32_t node : placed.nodes)
            (moving_.moves_mesh(node, placed.skin) || glass ? rigged : still).push_back(node);
        // adopt_rig() fills in where what is rigged lies.
        if (!rigged.empty()) {
            const std::shared_ptr<const ObjectMesh> object = with_tangents(placed.object, still.empty());
            for (const uint32_t node : rigged) {
                add_rigged_mesh(scene_, *rig_, object, node, placed.skin);
                rig_->meshes.back().transmits = glass;
            }
        }
        if (!still.empty()) place_still(placed, still);
        placed.object = nullptr;
    }

    /// The mesh with what its material asks for, as it is to move. Made of a copy, once, where others hold it as well:
    /// tangents of what stands still are made where it lies. `alone`: the caller needs it for nothing else.
    std::shared_ptr<const ObjectMesh> with_tangents(const std::shared_ptr<ObjectMesh>& object, bool alone) {
        const TextureRef& normal_texture = scene_.materials[object->mesh.material].normal_texture;
        if (!normal_texture.used() || !object->mesh.tangents.empty()) return object;
        const auto [made, is_new] = with_tangents_.try_emplace(object.get());
        if (!is_new) return made->second;
        const auto own = alone && object.use_count() == 1 ? object : std::make_shared<ObjectMesh>(*object);
        build_tangents(*own, normal_texture);
        return made->second = own;
    }

    void place_still(PlacedMesh& placed, const std::vector<uint32_t>& nodes) {
        const uint64_t copies = nodes.size();
        const bool bake_all = copies == 1 || placed.object->mesh.triangles.size() * copies < kMaxBakedCopyTriangles;
        std::optional<uint32_t> shared;
        for (size_t k = 0; k < copies; ++k) {
            const MeshPose pose = rest_pose(nodes[k], placed.skin);
            const bool singular = !placed.skin && std::fabs(glm::determinant(dmat3(pose.transforms.front()))) < 1e-30;
            if (bake_all || singular) {
                if (k + 1 == copies && placed.object.use_count() == 1) {
                    bake(*placed.object, pose, nodes[k]);
                    add_baked(std::move(placed.object->mesh));
                } else {
                    ObjectMesh copy = *placed.object;
                    bake(copy, pose, nodes[k]);
                    add_baked(std::move(copy.mesh));
                }
                continue;
            }
            if (!shared) {
                ObjectMesh object = *placed.object;
                const dmat4 unmoved(1);
                bake(object, {.weights = pose.weights, .transforms = {&unmoved, 1}}, nodes[k]);
                tally_.degenerate_triangles += drop_degenerate_triangles(object.mesh);
                if (object.mesh.triangles.empty()) return;
                add_tangents(object.mesh);
                shared = static_cast<uint32_t>(scene_.meshes.size());
                scene_.meshes.push_back(std::move(object.mesh));
            }
            scene_.instances.push_back(placed_instance(*shared, pose.transforms.front(), scene_.origin));
        }
    }

    static void bake(ObjectMesh& object, const MeshPose& pose, uint32_t node) {
        if (!pose_mesh(object, pose, object.mesh))
            throw Error(ErrorCode::BadScene, gltf_pointer("nodes", node),
                        "the node's transform moves a vertex out of float's range");
    }

    void add_baked(Mesh mesh) {
        tally_.degenerate_triangles += drop_degenerate_triangles(mesh);
        if (mesh.triangles.empty()) return;
        add_tangents(mesh);
        scene_.instances.push_back({.mesh = static_cast<uint32_t>(scene_.meshes.size())});
        scene_.meshes.push_back(std::move(mesh));
    }

    void add_tangents(Mesh& mesh) const {
        const TextureRef& normal_texture = scene_.materials[mesh.material].normal_texture;
        if (normal_texture.used() && mesh.tangents.empty()) build_tangents(mesh, normal_texture);
    }

    /// Extensions that are not supported may say where else the image is.
    static bool has_source(const tinygltf::Texture& texture) { return texture.source >= 0; }

    void note_scaled_to_nothing(const char* what, uint32_t node) {
        warnings_.push_back(std::string("the ") + what + " of node " + std::to_string(node) +
                            " was left out: its node is scaled to nothing");
    }

    void warn() {
        const auto note = [&](uint64_t count, const std::string& text) {
            if (count != 0) warnings_.push_back(std::to_string(count) + " " + text);
        };
        note(tally_.degenerate_triangles, "triangles without area were dropped");
        note(tally_.points_and_lines, "primitives of points or lines were skipped");
        note(tally_.clamped_colors, "vertex colours outside [0, 1] were clamped");
        note(tally_.bad_normals, "normals without direction were replaced by their triangles'");
        note(tally_.missing_uv_sets, "primitives lack texture coordinates that their material reads; (0, 0) is used");
        note(tally_.unweighted, "vertices have joints of no weight; the first one moves them");
        note(std::ranges::count_if(model_.textures, [](const auto& texture) { return !has_source(texture); }),
             "textures have no source image in a supported format; materials do without them");
        scene_.warnings.insert(scene_.warnings.end(), warnings_.begin(), warnings_.end());
    }

    const GltfDocument& document_;
    const tinygltf::Model& model_;
    GltfData& data_;
    const LoadLimits& limits_;
    Scene& scene_;
    const std::shared_ptr<Rig> rig_ = std::make_shared<Rig>();
    PosedRig rest_;
    Movement moving_;
    std::set<uint32_t> animated_materials_;  // of the document
    std::set<uint32_t> becoming_glass_;      // of them those whose transmission is animated
    std::set<uint32_t> ever_glass_;          // materials of the scene that transmit at some moment
    std::vector<PlacedMesh> meshes_;
    std::map<std::vector<uint32_t>, uint32_t> target_lists_;  // morph targets that matter to nodes, by index
    std::vector<const std::vector<uint32_t>*> by_index_;      // the same
    /// By a node's weights, or by the number of targets where all matter, which list it is.
    std::map<std::pair<const std::vector<double>*, uint32_t>, uint32_t> known_lists_;
    std::map<const ObjectMesh*, std::shared_ptr<const ObjectMesh>> with_tangents_;
    std::map<int, uint32_t> material_of_;
    std::vector<UvSlots> uv_slots_;  // of each of the scene's materials
    MeshTally tally_;
    std::vector<std::string> warnings_;
};

}  // namespace

std::shared_ptr<Rig> place_gltf_scene(const GltfDocument& document, GltfData& data, const LoadLimits& limits,
                                      Scene& scene) {
    return Placement(document, data, limits, scene).run();
}

}  // namespace photond
