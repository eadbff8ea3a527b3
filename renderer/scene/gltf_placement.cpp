#include "renderer/scene/gltf_placement.h"

#include <algorithm>
#include <map>
#include <set>

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

/// A mesh as read, and the nodes that show it.
struct PlacedMesh {
    ObjectMesh object;
    std::vector<uint32_t> nodes;
    std::optional<uint32_t> skin;  // then there is one node
};

bool finite(const dmat4& m) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!(std::fabs(m[column][row]) <= double{std::numeric_limits<float>::max()})) return false;
    return true;
}

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
        moving_ = moving_nodes(*rig_, rig_->animations);
        find_animated_materials();
        check_transforms();
        check_triangle_count();
        read_meshes();
        choose_origin();
        for (PlacedMesh& placed : meshes_) place(placed);
        for (const uint32_t node : place_cameras(*rig_, rest_, scene_)) note_scaled_to_nothing("camera", node);
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
                if (channel.property >= Property::BaseColor)
                    animated_materials_.insert(channel.targets.begin(), channel.targets.end());
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
            if ((model_.nodes[i].mesh >= 0 || node.camera >= 0 || node.light >= 0) && !finite(rest_.world[i]))
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
        // Nodes that show the same mesh in the same shape share one reading of it: a range of meshes_.
        std::map<int, std::pair<size_t, size_t>> shared;
        for (const uint32_t i : rig_->walk) {
            const tinygltf::Node& node = model_.nodes[i];
            if (node.mesh < 0) continue;
            const bool own_shape = node.skin >= 0 || !node.weights.empty() || changes_weights(rig_->animations, i);
            if (const auto found = shared.find(node.mesh); found != shared.end() && !own_shape) {
                for (size_t k = found->second.first; k < found->second.second; ++k) meshes_[k].nodes.push_back(i);
                continue;
            }
            const size_t first = meshes_.size();
            read_mesh(i);
            if (!own_shape) shared.emplace(node.mesh, std::pair{first, meshes_.size()});
        }
    }

    void read_mesh(uint32_t node_index) {
        const tinygltf::Node& node = model_.nodes[node_index];
        const tinygltf::Mesh& mesh = model_.meshes[node.mesh];
        const size_t joints = node.skin >= 0 ? rig_->skins[static_cast<size_t>(node.skin)].joints.size() : 0;
        for (uint32_t p = 0; p < mesh.primitives.size(); ++p) {
            const tinygltf::Primitive& primitive = mesh.primitives[p];
            const auto positions = gltf_attribute(primitive, "POSITION");
            if (!positions) continue;
            if (primitive.mode < 4) {
                ++tally_.points_and_lines;
                continue;
            }
            if (is_one_point(primitive, *positions) || (primitive.indices >= 0 && is_zeros(primitive.indices))) {
                tally_.degenerate_triangles += promised_triangles(primitive, model_);
                continue;
            }
            const uint32_t material = use_material(primitive.material);
            PlacedMesh placed;
            placed.object = read_primitive_mesh(document_, data_, node.mesh, p, joints, wants_of(material), tally_);
            if (placed.object.mesh.triangles.empty()) continue;
            placed.object.mesh.material = material;
            placed.nodes = {node_index};
            if (node.skin >= 0) placed.skin = static_cast<uint32_t>(node.skin);
            if (placed.skin && placed.object.joint_sets == 0)
                throw Error(ErrorCode::BadScene, gltf_pointer("nodes", node_index, "skin"),
                            "the mesh has no JOINTS_0 and WEIGHTS_0");
            meshes_.push_back(std::move(placed));
        }
    }

    /// An accessor of nothing but zeros: one point, or one corner, again and again.
    bool is_zeros(int accessor) const {
        return model_.accessors[accessor].bufferView < 0 && !model_.accessors[accessor].sparse.isSparse;
    }
    /// Positions that are all zeros, and that no morph target moves apart.
    bool is_one_point(const tinygltf::Primitive& primitive, int positions) const {
        return is_zeros(positions) && std::ranges::all_of(primitive.targets, [&](const auto& target) {
                   const auto moved = target.find("POSITION");
                   return moved == target.end() || is_zeros(moved->second);
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
        MeshPose pose = pose_of(*rig_, rest_, node, skin, scene_.origin);
        for (size_t k = 0; skin && k < pose.transforms.size(); ++k)
            if (!finite(pose.transforms[k]))
                throw Error(ErrorCode::BadScene, gltf_pointer("skins", *skin, "joints", std::to_string(k)),
                            "the joint's transform is not finite");
        return pose;
    }

    /// A box around the scene from boxes around its meshes: as good as needed to tell where it lies.
    void choose_origin() {
        Bounds bounds;
        for (const PlacedMesh& placed : meshes_) {
            Bounds object;
            for (const vec3& p : placed.object.mesh.positions) object.extend(dvec3(p));
            std::vector<dmat4> matrices;
            for (const uint32_t node : placed.nodes) {
                const MeshPose pose = rest_pose(node, placed.skin);
                matrices.insert(matrices.end(), pose.transforms.begin(), pose.transforms.end());
            }
            for (const dmat4& m : matrices)
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
        const bool glass = scene_.materials[placed.object.mesh.material].transmission > 0 && !rig_->animations.empty();
        std::vector<uint32_t> rigged, still;
        for (const uint32_t node : placed.nodes)
            (moves_mesh(*rig_, rig_->animations, moving_, node, placed.skin) || glass ? rigged : still).push_back(node);
        if (!rigged.empty())
            place_rigged(still.empty() ? std::move(placed.object) : placed.object, placed.skin, rigged);
        if (!still.empty()) place_still(placed, still);
    }

    /// adopt_rig() fills in where it lies.
    void place_rigged(ObjectMesh object, std::optional<uint32_t> skin, const std::vector<uint32_t>& nodes) {
        const Material& material = scene_.materials[object.mesh.material];
        if (material.normal_texture.used() && object.mesh.tangents.empty())
            build_tangents(object, material.normal_texture);
        const auto shared = std::make_shared<const ObjectMesh>(std::move(object));
        for (const uint32_t node : nodes) add_rigged_mesh(scene_, *rig_, shared, node, skin);
    }

    void place_still(PlacedMesh& placed, const std::vector<uint32_t>& nodes) {
        const uint64_t copies = nodes.size();
        const bool bake_all = copies == 1 || placed.object.mesh.triangles.size() * copies < kMaxBakedCopyTriangles;
        std::optional<uint32_t> shared;
        for (size_t k = 0; k < copies; ++k) {
            const MeshPose pose = rest_pose(nodes[k], placed.skin);
            const bool singular = !placed.skin && std::fabs(glm::determinant(dmat3(pose.transforms.front()))) < 1e-30;
            if (bake_all || singular) {
                if (k + 1 == copies && !shared) {
                    bake(placed.object, pose, nodes[k]);
                    add_baked(std::move(placed.object.mesh));
                } else {
                    ObjectMesh copy = placed.object;
                    bake(copy, pose, nodes[k]);
                    add_baked(std::move(copy.mesh));
                }
                continue;
            }
            if (!shared) {
                ObjectMesh object = placed.object;
                bake(object, {.weights = pose.weights, .transforms = {dmat4(1)}}, nodes[k]);
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
    std::vector<bool> moving_;               // nodes
    std::set<uint32_t> animated_materials_;  // of the document
    std::vector<PlacedMesh> meshes_;
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
