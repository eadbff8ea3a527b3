#include "renderer/scene/gltf_placement.h"

#include <algorithm>
#include <map>

#include "renderer/scene/gltf_mesh.h"

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
    uint32_t mesh = 0;       // of the document
    uint32_t primitive = 0;  // of that mesh
    std::vector<uint32_t> nodes;
    bool skinned = false;  // then there is one node
};

bool finite(const dmat4& m) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!(std::fabs(m[column][row]) <= double{std::numeric_limits<float>::max()})) return false;
    return true;
}

/// Transforms normals, up to length: the inverse transpose times the determinant, which exists for flattened meshes
/// too; its sign is taken out so that normals keep to their side.
dmat3 normal_matrix(const dmat3& m) {
    const double sign = glm::determinant(m) < 0 ? -1 : 1;
    return dmat3(glm::cross(m[1], m[2]) * sign, glm::cross(m[2], m[0]) * sign, glm::cross(m[0], m[1]) * sign);
}

vec3 unit_or(const dvec3& v, const vec3& fallback) {
    const double length = glm::length(v);
    return length > 0 && std::isfinite(length) ? vec3(v / length) : fallback;
}

class Placement {
public:
    Placement(const GltfDocument& document, GltfData& data, const LoadLimits& limits, Scene& scene)
        : document_(document), model_(document.model), data_(data), limits_(limits), scene_(scene) {}

    void run() {
        compute_world_matrices();
        walk_default_scene();
        check_triangle_count();
        read_meshes();
        choose_origin();
        for (PlacedMesh& placed : meshes_) place(placed);
        place_cameras();
        place_lights();
        warn();
    }

private:
    void compute_world_matrices() {
        const std::vector<tinygltf::Node>& nodes = model_.nodes;
        std::vector<bool> is_child(nodes.size(), false);
        for (const tinygltf::Node& node : nodes)
            for (const int child : node.children) is_child[child] = true;
        for (uint32_t i = 0; i < nodes.size(); ++i)
            if (!is_child[i]) roots_.push_back(static_cast<int>(i));
        world_.resize(nodes.size());
        for (const int root : roots_) world_[root] = gltf_local_matrix(nodes[root]);
        for (std::vector<int> open = roots_; !open.empty();) {
            const int i = open.back();
            open.pop_back();
            for (const int child : nodes[i].children) world_[child] = world_[i] * gltf_local_matrix(nodes[child]);
            open.insert(open.end(), nodes[i].children.begin(), nodes[i].children.end());
        }
    }

    void walk_default_scene() {
        std::vector<uint32_t> open;
        const auto push = [&open](const std::vector<int>& nodes) {
            open.insert(open.end(), nodes.rbegin(), nodes.rend());
        };
        push(document_.scene() != nullptr ? document_.scene()->nodes : roots_);
        while (!open.empty()) {
            const uint32_t i = open.back();
            open.pop_back();
            const tinygltf::Node& node = model_.nodes[i];
            if ((node.mesh >= 0 || node.camera >= 0 || gltf_light(node)) && !finite(world_[i]))
                throw Error(ErrorCode::BadScene, gltf_pointer("nodes", i),
                            "the node's transform, with its parents', is not finite in single precision");
            walk_.push_back(i);
            push(node.children);
        }
    }

    void check_triangle_count() const {
        uint64_t total = 0;
        for (const uint32_t i : walk_) {
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
        for (const uint32_t i : walk_) {
            const tinygltf::Node& node = model_.nodes[i];
            if (node.mesh < 0) continue;
            const bool own_shape = node.skin >= 0 || !node.weights.empty();
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
        const std::vector<double>& weights = node.weights.empty() ? mesh.weights : node.weights;
        morphed_ += std::ranges::any_of(weights, [](double w) { return static_cast<float>(w) != 0; }) ||
                    (!mesh.primitives.empty() && !mesh.primitives.front().targets.empty());
        skinned_ += node.skin >= 0;
        for (uint32_t p = 0; p < mesh.primitives.size(); ++p) {
            const tinygltf::Primitive& primitive = mesh.primitives[p];
            const auto positions = gltf_attribute(primitive, "POSITION");
            if (!positions) continue;
            if (primitive.mode < 4) {
                ++tally_.points_and_lines;
                continue;
            }
            if (is_zeros(*positions) || (primitive.indices >= 0 && is_zeros(primitive.indices))) {
                tally_.degenerate_triangles += promised_triangles(primitive, model_);
                continue;
            }
            const uint32_t material = use_material(primitive.material);
            PlacedMesh placed;
            placed.object = read_primitive_mesh(document_, data_, node.mesh, p, weights, wants_of(material), tally_);
            if (placed.object.mesh.triangles.empty()) continue;
            placed.object.mesh.material = material;
            placed.mesh = node.mesh;
            placed.primitive = p;
            placed.nodes = {node_index};
            placed.skinned = node.skin >= 0;
            if (placed.skinned && placed.object.joint_sets == 0)
                throw Error(ErrorCode::BadScene, gltf_pointer("nodes", node_index, "skin"),
                            "the mesh has no JOINTS_0 and WEIGHTS_0");
            meshes_.push_back(std::move(placed));
        }
    }

    /// An accessor of nothing but zeros: one point, or one corner, again and again.
    bool is_zeros(int accessor) const {
        return model_.accessors[accessor].bufferView < 0 && !model_.accessors[accessor].sparse.isSparse;
    }

    /// The scene's index of a document's material, entered when it is used for the first time.
    uint32_t use_material(int index) {
        const auto [found, is_new] = material_of_.try_emplace(index, static_cast<uint32_t>(scene_.materials.size()));
        if (!is_new) return found->second;
        Material material = index < 0 ? Material{} : read_gltf_material(model_.materials[index]);
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

    std::vector<dmat4> joint_matrices(const PlacedMesh& placed) {
        const int skin_index = model_.nodes[placed.nodes.front()].skin;
        const tinygltf::Skin& skin = model_.skins[skin_index];
        std::optional<AccessorView> inverse_bind;
        if (skin.inverseBindMatrices >= 0) inverse_bind = data_.accessor(skin.inverseBindMatrices);
        std::vector<dmat4> joints(skin.joints.size());
        for (size_t k = 0; k < joints.size(); ++k) {
            joints[k] = world_[skin.joints[k]] * (inverse_bind ? inverse_bind->matrix(k) : dmat4(1));
            if (!finite(joints[k]))
                throw Error(ErrorCode::BadScene, gltf_pointer("skins", skin_index, "joints", std::to_string(k)),
                            "the joint's transform is not finite");
        }
        return joints;
    }

    /// A box around the scene from boxes around its meshes: as good as needed to tell where it lies.
    void choose_origin() {
        Bounds bounds;
        for (const PlacedMesh& placed : meshes_) {
            Bounds object;
            for (const vec3& p : placed.object.mesh.positions) object.extend(dvec3(p));
            std::vector<dmat4> matrices;
            if (placed.skinned)
                matrices = joint_matrices(placed);
            else
                for (const uint32_t node : placed.nodes) matrices.push_back(world_[node]);
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

    void place(PlacedMesh& placed) {
        if (placed.skinned) {
            skin_to_world(placed);
            return add_baked(std::move(placed.object.mesh), placed);
        }
        const uint64_t copies = placed.nodes.size();
        const bool bake_all = copies == 1 || placed.object.mesh.triangles.size() * copies < kMaxBakedCopyTriangles;
        std::optional<uint32_t> shared;
        for (size_t k = 0; k < copies; ++k) {
            const dmat4& to_world = world_[placed.nodes[k]];
            const bool singular = std::fabs(glm::determinant(dmat3(to_world))) < 1e-30;
            if (bake_all || singular) {
                Mesh copy = k + 1 == copies && !shared ? std::move(placed.object.mesh) : placed.object.mesh;
                bake(copy, to_world, placed.nodes[k]);
                add_baked(std::move(copy), placed);
            } else {
                if (!shared) {
                    Mesh mesh = placed.object.mesh;
                    add_tangents(mesh);
                    shared = static_cast<uint32_t>(scene_.meshes.size());
                    scene_.meshes.push_back(std::move(mesh));
                }
                add_instance(*shared, to_world);
            }
        }
    }

    void add_instance(uint32_t mesh, const dmat4& to_world) {
        Instance instance;
        instance.mesh = mesh;
        instance.identity = false;
        dmat4 moved = to_world;
        moved[3] -= dvec4(scene_.origin, 0);
        instance.to_world = mat4x3(mat4(moved));
        const dmat3 linear(to_world);
        instance.normal_to_world = mat3(glm::transpose(glm::inverse(linear)));
        instance.flips_orientation = glm::determinant(linear) < 0;
        scene_.instances.push_back(instance);
    }

    void bake(Mesh& mesh, const dmat4& to_world, uint32_t node) {
        if (to_world == dmat4(1) && scene_.origin == dvec3(0)) return;  // keeps the file's bits
        const dmat3 linear(to_world);
        const dmat3 normals = normal_matrix(linear);
        for (vec3& p : mesh.positions) {
            p = vec3(dvec3(to_world * dvec4(dvec3(p), 1)) - scene_.origin);
            if (!is_finite(p)) fail_position(node);
        }
        for (vec3& n : mesh.normals) n = unit_or(normals * dvec3(n), vec3(0, 1, 0));
        const bool mirrored = glm::determinant(linear) < 0;
        for (vec4& t : mesh.tangents) t = vec4(unit_or(linear * dvec3(t), vec3(1, 0, 0)), mirrored ? -t.w : t.w);
        if (mirrored)
            for (uvec3& t : mesh.triangles) std::swap(t.y, t.z);
    }

    /// glTF 2.0, 3.7.3.3: the joints move the vertices straight to world space; the node's own transform does not
    /// count.
    void skin_to_world(PlacedMesh& placed) {
        const std::vector<dmat4> joints = joint_matrices(placed);
        ObjectMesh& object = placed.object;
        Mesh& mesh = object.mesh;
        const size_t influences = size_t{object.joint_sets} * 4;
        for (size_t v = 0; v < mesh.positions.size(); ++v) {
            dmat4 blended(0.0);
            for (size_t k = 0; k < influences; ++k) {
                const JointWeight& influence = object.influences[v * influences + k];
                if (influence.weight == 0) continue;
                if (influence.joint >= joints.size())
                    throw Error(ErrorCode::BadScene,
                                gltf_pointer("meshes", placed.mesh, "primitives", std::to_string(placed.primitive),
                                             "attributes", "JOINTS_0"),
                                "joint " + std::to_string(influence.joint) + " is not one of the skin's " +
                                    std::to_string(joints.size()));
                blended += joints[influence.joint] * double{influence.weight};
            }
            const dmat3 linear(blended);
            mesh.positions[v] = vec3(dvec3(blended * dvec4(dvec3(mesh.positions[v]), 1)) - scene_.origin);
            if (!is_finite(mesh.positions[v])) fail_position(placed.nodes.front());
            if (!mesh.normals.empty())
                mesh.normals[v] = unit_or(normal_matrix(linear) * dvec3(mesh.normals[v]), vec3(0, 1, 0));
            if (!mesh.tangents.empty())
                mesh.tangents[v] = vec4(unit_or(linear * dvec3(mesh.tangents[v]), vec3(1, 0, 0)), mesh.tangents[v].w);
        }
    }

    void add_baked(Mesh mesh, const PlacedMesh& placed) {
        tally_.degenerate_triangles += drop_degenerate_triangles(mesh);
        if (mesh.triangles.empty()) return;
        mesh.material = placed.object.mesh.material;
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

    [[noreturn]] static void fail_position(uint32_t node) {
        throw Error(ErrorCode::BadScene, gltf_pointer("nodes", node),
                    "the node's transform moves a vertex out of float's range");
    }

    void place_cameras() {
        for (const uint32_t i : walk_) {
            const tinygltf::Node& node = model_.nodes[i];
            if (node.camera < 0) continue;
            Camera camera = read_gltf_camera(model_.cameras[node.camera]);
            const dmat4& m = world_[i];
            // The axes are made orthonormal: scale does not act on a camera.
            const dvec3 back(m[2]), up(m[1]);
            const dvec3 right = glm::cross(up, back);
            if (!(glm::length(back) > 0) || !(glm::length(right) > 1e-9 * glm::length(up) * glm::length(back))) {
                warnings_.push_back("the camera of node " + std::to_string(i) +
                                    " was left out: its node is scaled to nothing");
                continue;
            }
            camera.forward = vec3(-glm::normalize(back));
            camera.right = vec3(glm::normalize(right));
            camera.up = vec3(glm::normalize(glm::cross(back, right)));
            camera.position = vec3(dvec3(m[3]) - scene_.origin);
            if (!node.name.empty()) camera.name = node.name;
            if (camera.name.empty()) camera.name = "camera_" + std::to_string(scene_.cameras.size());
            scene_.cameras.push_back(camera);
        }
    }

    void place_lights() {
        for (const uint32_t i : walk_) {
            const tinygltf::Node& node = model_.nodes[i];
            const auto index = gltf_light(node);
            if (!index) continue;
            PunctualLight light = read_gltf_light(model_.lights[*index]);
            const dvec3 back(world_[i][2]);
            if (light.kind != PunctualLight::Kind::Point && !(glm::length(back) > 0)) {
                warnings_.push_back("the light of node " + std::to_string(i) +
                                    " was left out: its node is scaled to nothing");
                continue;
            }
            light.position = vec3(dvec3(world_[i][3]) - scene_.origin);
            light.direction = unit_or(-back, vec3(0, 0, -1));
            if (!node.name.empty()) light.name = node.name;
            scene_.punctual_lights.push_back(light);
        }
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
        note(skinned_, "skinned meshes are posed by their joints' own transforms, at rest");
        note(morphed_, "meshes with morph targets are posed at their stored weights, at rest");
        note(std::ranges::count_if(model_.textures, [](const auto& texture) { return !has_source(texture); }),
             "textures have no source image in a supported format; materials do without them");
        note(model_.animations.size(), "animations are not played: the scene is posed at rest");
        scene_.warnings.insert(scene_.warnings.end(), warnings_.begin(), warnings_.end());
        scene_.animation_count = static_cast<uint32_t>(model_.animations.size());
    }

    const GltfDocument& document_;
    const tinygltf::Model& model_;
    GltfData& data_;
    const LoadLimits& limits_;
    Scene& scene_;
    std::vector<int> roots_;      // nodes without a parent
    std::vector<dmat4> world_;    // of every node
    std::vector<uint32_t> walk_;  // nodes of the default scene, depth first
    std::vector<PlacedMesh> meshes_;
    std::map<int, uint32_t> material_of_;
    std::vector<UvSlots> uv_slots_;  // of each of the scene's materials
    MeshTally tally_;
    uint64_t skinned_ = 0;
    uint64_t morphed_ = 0;
    std::vector<std::string> warnings_;
};

}  // namespace

void place_gltf_scene(const GltfDocument& document, GltfData& data, const LoadLimits& limits, Scene& scene) {
    Placement(document, data, limits, scene).run();
}

}  // namespace photond
