#include "renderer/scene/gltf_mesh.h"

#include <algorithm>
#include <numeric>

namespace photond {

namespace {

constexpr int kTriangles = TINYGLTF_MODE_TRIANGLES, kTriangleStrip = TINYGLTF_MODE_TRIANGLE_STRIP;

/// One primitive at work: its accessors, and the vertices its triangles use.
class PrimitiveReader {
public:
    PrimitiveReader(const GltfDocument& document, GltfData& data, uint32_t mesh, uint32_t primitive)
        : primitive_(document.model.meshes[mesh].primitives[primitive]),
          data_(data),
          pointer_(gltf_pointer("meshes", mesh, "primitives", std::to_string(primitive))),
          positions_(data.accessor(*gltf_attribute(primitive_, "POSITION"))) {}

    ObjectMesh read(const MeshShape& shape, const MeshWants& wants, MeshTally& tally) {
        read_triangles();
        keep_used_vertices();
        read_positions();
        read_normals(tally);
        read_uv(wants, tally);
        read_colors(tally);
        if (shape.joints > 0) read_influences(shape.joints, tally);
        const bool tangents_wanted = wants.normal_texture != nullptr;
        if (tangents_wanted) read_tangents();
        read_targets(shape.targets);
        mesh_.material = 0;
        return std::move(result_);
    }

private:
    [[noreturn]] void fail(const std::string& where, const std::string& detail) const {
        throw Error(ErrorCode::BadScene, pointer_ + where, detail);
    }
    std::optional<AccessorView> attribute(const std::string& semantic) const {
        const auto index = gltf_attribute(primitive_, semantic);
        if (!index) return std::nullopt;
        return data_.accessor(*index);
    }

    void read_triangles() {
        std::optional<AccessorView> indices;
        if (primitive_.indices >= 0) indices = data_.accessor(primitive_.indices);
        const uint64_t corner_count = indices ? indices->count() : positions_.count();
        std::vector<uint32_t> corners(corner_count);
        if (indices) {
            for (uint64_t i = 0; i < corner_count; ++i) {
                corners[i] = indices->whole(i);
                if (corners[i] >= positions_.count())
                    fail("/indices", "index " + std::to_string(corners[i]) + " at position " + std::to_string(i) +
                                         " is not below the vertex count " + std::to_string(positions_.count()));
            }
        } else {
            std::iota(corners.begin(), corners.end(), 0u);
        }
        // glTF 2.0, 3.7.2.1: the formulas for each topology; odd triangles of a strip have their corners turned back.
        if (primitive_.mode == kTriangles) {
            mesh_.triangles.reserve(corner_count / 3);
            for (uint64_t i = 0; i + 2 < corner_count; i += 3)
                mesh_.triangles.emplace_back(corners[i], corners[i + 1], corners[i + 2]);
        } else if (primitive_.mode == kTriangleStrip) {
            for (uint64_t i = 0; i + 2 < corner_count; ++i)
                mesh_.triangles.emplace_back(corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]);
        } else {
            for (uint64_t i = 1; i + 1 < corner_count; ++i)
                mesh_.triangles.emplace_back(corners[i], corners[i + 1], corners[0]);
        }
    }

    /// Files share one long vertex array between many primitives: each mesh keeps the vertices it uses, in their order.
    void keep_used_vertices() {
        const uint64_t count = positions_.count();
        if (mesh_.triangles.size() * 3 < count / 16) {
            for (const uvec3& t : mesh_.triangles) vertices_.insert(vertices_.end(), {t.x, t.y, t.z});
            std::ranges::sort(vertices_);
            vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
            for (uvec3& t : mesh_.triangles)
                for (int k = 0; k < 3; ++k)
                    t[k] = static_cast<uint32_t>(std::ranges::lower_bound(vertices_, t[k]) - vertices_.begin());
            return;
        }
        std::vector<uint32_t> place(count, UINT32_MAX);
        for (const uvec3& t : mesh_.triangles)
            for (int k = 0; k < 3; ++k) place[t[k]] = 0;
        for (uint32_t v = 0; v < count; ++v) {
            if (place[v] == UINT32_MAX) continue;
            place[v] = static_cast<uint32_t>(vertices_.size());
            vertices_.push_back(v);
        }
        for (uvec3& t : mesh_.triangles) t = uvec3(place[t.x], place[t.y], place[t.z]);
    }

    void read_positions() {
        mesh_.positions.resize(vertices_.size());
        for (size_t v = 0; v < vertices_.size(); ++v) {
            mesh_.positions[v] = positions_.vec<3>(vertices_[v]);
            if (!is_finite(mesh_.positions[v]))
                fail("/attributes/POSITION",
                     "the position of vertex " + std::to_string(vertices_[v]) + " is not finite");
        }
    }

    void read_normals(MeshTally& tally) {
        const auto normals = attribute("NORMAL");
        if (!normals) return;
        mesh_.normals.resize(vertices_.size());
        std::vector<bool> bad(vertices_.size(), false);
        bool any_bad = false;
        for (size_t v = 0; v < vertices_.size(); ++v) {
            const vec3 n = normals->vec<3>(vertices_[v]);
            const float length = glm::length(n);
            if (length > 1e-20f && std::isfinite(length)) {
                mesh_.normals[v] = n / length;
            } else {
                bad[v] = any_bad = true;
                ++tally.bad_normals;
            }
        }
        if (any_bad) replace_normals(mesh_, bad);
    }

    void read_uv(const MeshWants& wants, MeshTally& tally) {
        bool missing = false;
        for (int slot = 0; slot < 2; ++slot) {
            const auto set = wants.uv.set[slot];
            if (!set) continue;
            const auto uv = attribute("TEXCOORD_" + std::to_string(*set));
            if (!uv) {
                missing = true;
                continue;
            }
            mesh_.uv[slot].resize(vertices_.size());
            for (size_t v = 0; v < vertices_.size(); ++v) {
                const vec2 value = uv->vec<2>(vertices_[v]);
                if (!std::isfinite(value.x) || !std::isfinite(value.y))
                    fail("/attributes/TEXCOORD_" + std::to_string(*set),
                         "the coordinates of vertex " + std::to_string(vertices_[v]) + " are not finite");
                mesh_.uv[slot][v] = value;
            }
        }
        tally.missing_uv_sets += missing;
    }

    void read_colors(MeshTally& tally) {
        const auto colors = attribute("COLOR_0");
        if (!colors) return;
        mesh_.colors.resize(vertices_.size());
        for (size_t v = 0; v < vertices_.size(); ++v) {
            vec4 color(colors->vec<3>(vertices_[v]), colors->rows() == 4 ? colors->value(vertices_[v], 3) : 1.0f);
            for (int k = 0; k < 4; ++k)
                if (!std::isfinite(color[k]))
                    fail("/attributes/COLOR_0",
                         "the colour of vertex " + std::to_string(vertices_[v]) + " is not finite");
            const vec4 clamped = glm::clamp(color, 0.0f, 1.0f);
            tally.clamped_colors += clamped != color;
            mesh_.colors[v] = clamped;
        }
        // White everywhere multiplies nothing.
        if (std::ranges::all_of(mesh_.colors, [](const vec4& c) { return c == vec4(1); })) mesh_.colors = {};
    }

    void read_influences(size_t joint_count, MeshTally& tally) {
        for (uint32_t set = 0;; ++set) {
            const auto joints = attribute("JOINTS_" + std::to_string(set));
            const auto weights = attribute("WEIGHTS_" + std::to_string(set));
            if (!joints || !weights) break;
            influence_sets_.push_back({*joints, *weights});
        }
        result_.joint_sets = static_cast<uint32_t>(influence_sets_.size());
        if (influence_sets_.size() > 1)  // they may all be the same accessors
            data_.charge((influence_sets_.size() - 1) * 4 * sizeof(JointWeight) * vertices_.size(),
                         pointer_ + "/attributes/JOINTS_1");
        result_.influences.reserve(vertices_.size() * 4 * influence_sets_.size());
        for (const uint32_t v : vertices_) {
            float sum = 0;
            const size_t first = result_.influences.size();
            for (const auto& [joints, weights] : influence_sets_) {
                for (uint32_t k = 0; k < 4; ++k) {
                    const float weight = weights.value(v, k);
                    if (!(weight >= 0) || !std::isfinite(weight))
                        fail("/attributes/WEIGHTS_0",
                             "a weight of vertex " + std::to_string(v) + " is negative or not finite");
                    const uint32_t joint = joints.whole(v, k);
                    if (joint >= joint_count && weight > 0)
                        fail("/attributes/JOINTS_0", "joint " + std::to_string(joint) + " is not one of the skin's " +
                                                         std::to_string(joint_count));
                    result_.influences.push_back({joint, weight});
                    sum += weight;
                }
            }
            if (sum > 0 || influence_sets_.empty()) continue;
            // Of no weights the first joint has all.
            JointWeight& whole = result_.influences[first];
            if (whole.joint >= joint_count) whole.joint = 0;
            whole.weight = 1;
            ++tally.unweighted;
        }
    }

    void read_tangents() {
        const auto tangents = attribute("TANGENT");
        if (!tangents || mesh_.normals.empty()) return;  // glTF: without normals, tangents are ignored
        mesh_.tangents.resize(vertices_.size());
        for (size_t v = 0; v < vertices_.size(); ++v) {
            const vec4 t = tangents->vec<4>(vertices_[v]);
            const float length = glm::length(vec3(t));
            if (!(length > 1e-20f) || !std::isfinite(length) || t.w == 0 || !std::isfinite(t.w)) {
                mesh_.tangents = {};  // unusable: they are computed instead
                return;
            }
            mesh_.tangents[v] = vec4(vec3(t) / length, t.w < 0 ? -1.0f : 1.0f);
        }
    }

    void read_targets(std::span<const uint32_t> kept) {
        for (const uint32_t k : kept) {
            MorphTarget target;
            target.weight = k;
            for (const auto& [semantic, accessor] : primitive_.targets[k]) {
                std::vector<vec3>* offsets = semantic == "POSITION"                             ? &target.positions
                                             : semantic == "NORMAL" && !mesh_.normals.empty()   ? &target.normals
                                             : semantic == "TANGENT" && !mesh_.tangents.empty() ? &target.tangents
                                                                                                : nullptr;
                if (offsets == nullptr) continue;
                const AccessorView view = data_.accessor(accessor);
                if (view.is_zeros()) continue;
                const std::string where = "/targets/" + std::to_string(k) + "/" + semantic;
                data_.charge(vertices_.size() * sizeof(vec3), pointer_ + where);
                offsets->resize(vertices_.size());
                for (size_t v = 0; v < vertices_.size(); ++v) {
                    (*offsets)[v] = view.vec<3>(vertices_[v]);
                    if (!is_finite((*offsets)[v]))
                        fail(where, "the displacement of vertex " + std::to_string(vertices_[v]) + " is not finite");
                }
            }
            if (!target.positions.empty() || !target.normals.empty() || !target.tangents.empty())
                result_.targets.push_back(std::move(target));
        }
    }

    const tinygltf::Primitive& primitive_;
    GltfData& data_;
    std::string pointer_;
    AccessorView positions_;
    std::vector<std::pair<AccessorView, AccessorView>> influence_sets_;
    std::vector<uint32_t> vertices_;  // of the file, that are kept
    ObjectMesh result_;
    Mesh& mesh_ = result_.mesh;
};

}  // namespace

uint64_t promised_triangles(const tinygltf::Primitive& primitive, const tinygltf::Model& model) {
    const auto positions = gltf_attribute(primitive, "POSITION");
    if (!positions || primitive.mode < kTriangles) return 0;
    const uint64_t corners = model.accessors[primitive.indices >= 0 ? primitive.indices : *positions].count;
    if (primitive.mode == kTriangles) return corners / 3;
    return corners < 3 ? 0 : corners - 2;
}

ObjectMesh read_primitive_mesh(const GltfDocument& document, GltfData& data, uint32_t mesh, uint32_t primitive,
                               const MeshShape& shape, const MeshWants& wants, MeshTally& tally) {
    return PrimitiveReader(document, data, mesh, primitive).read(shape, wants, tally);
}

}  // namespace photond
