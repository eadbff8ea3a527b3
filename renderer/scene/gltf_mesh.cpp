#include "renderer/scene/gltf_mesh.h"

#include <algorithm>
#include <cfloat>
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

    ObjectMesh read(std::span<const double> weights, const MeshWants& wants, MeshTally& tally) {
        read_triangles();
        keep_used_vertices();
        read_positions();
        read_normals(tally);
        read_uv(wants, tally);
        read_colors(tally);
        read_influences();
        const bool tangents_wanted = wants.normal_texture != nullptr;
        if (tangents_wanted) read_tangents();
        apply_morph_targets(weights);
        result_.dropped = drop_degenerate_triangles(mesh_);
        tally.degenerate_triangles += result_.dropped;
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
            check_position(v);
        }
    }
    void check_position(size_t v) const {
        if (!is_finite(mesh_.positions[v]))
            fail("/attributes/POSITION", "the position of vertex " + std::to_string(vertices_[v]) + " is not finite");
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
        if (any_bad) replace_normals(bad);
    }
    /// A normal without direction is replaced by the mean of its triangles' normals.
    void replace_normals(const std::vector<bool>& bad) {
        std::vector<dvec3> sum(vertices_.size(), dvec3(0));
        for (const uvec3& t : mesh_.triangles) {
            const dvec3 a(mesh_.positions[t.x]), b(mesh_.positions[t.y]), c(mesh_.positions[t.z]);
            for (int k = 0; k < 3; ++k) sum[t[k]] += glm::cross(b - a, c - a);
        }
        for (size_t v = 0; v < vertices_.size(); ++v) {
            if (!bad[v]) continue;
            const double length = glm::length(sum[v]);
            mesh_.normals[v] = length > 0 && std::isfinite(length) ? vec3(sum[v] / length) : vec3(0, 1, 0);
        }
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

    void read_influences() {
        for (uint32_t set = 0;; ++set) {
            const auto joints = attribute("JOINTS_" + std::to_string(set));
            const auto weights = attribute("WEIGHTS_" + std::to_string(set));
            if (!joints || !weights) break;
            influence_sets_.push_back({*joints, *weights});
        }
        result_.joint_sets = static_cast<uint32_t>(influence_sets_.size());
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
                    result_.influences.push_back({joints.whole(v, k), weight});
                    sum += weight;
                }
            }
            if (influence_sets_.empty()) continue;
            if (!(sum > 0) || !std::isfinite(sum))
                fail("/attributes/WEIGHTS_0", "the weights of vertex " + std::to_string(v) + " do not add up to 1");
            for (size_t i = first; i < result_.influences.size(); ++i) result_.influences[i].weight /= sum;
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

    /// glTF 2.0, 3.7.2.2: the weighted displacements are added. Handedness is not displaced.
    void apply_morph_targets(std::span<const double> weights) {
        const size_t count = std::min(weights.size(), primitive_.targets.size());
        bool moved = false;
        for (size_t k = 0; k < count; ++k) {
            const auto weight = static_cast<float>(weights[k]);
            if (weight == 0) continue;
            moved = true;
            for (const auto& [semantic, accessor] : primitive_.targets[k]) {
                const AccessorView offsets = data_.accessor(accessor);
                for (size_t v = 0; v < vertices_.size(); ++v) {
                    const vec3 offset = weight * offsets.vec<3>(vertices_[v]);
                    if (semantic == "POSITION") mesh_.positions[v] += offset;
                    if (semantic == "NORMAL" && !mesh_.normals.empty()) mesh_.normals[v] += offset;
                    if (semantic == "TANGENT" && !mesh_.tangents.empty()) mesh_.tangents[v] += vec4(offset, 0);
                }
            }
        }
        if (!moved) return;
        for (size_t v = 0; v < vertices_.size(); ++v) check_position(v);
        std::vector<bool> bad(mesh_.normals.size(), false);
        for (size_t v = 0; v < mesh_.normals.size(); ++v) {
            const float length = glm::length(mesh_.normals[v]);
            bad[v] = !(length > 1e-20f) || !std::isfinite(length);
            if (!bad[v]) mesh_.normals[v] /= length;
        }
        if (std::ranges::find(bad, true) != bad.end()) replace_normals(bad);
        for (vec4& t : mesh_.tangents) {
            const float length = glm::length(vec3(t));
            if (!(length > 1e-20f) || !std::isfinite(length)) {
                mesh_.tangents = {};
                break;
            }
            t = vec4(vec3(t) / length, t.w);
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
                               std::span<const double> weights, const MeshWants& wants, MeshTally& tally) {
    return PrimitiveReader(document, data, mesh, primitive).read(weights, wants, tally);
}

uint64_t drop_degenerate_triangles(Mesh& mesh) {
    const auto degenerate = [&mesh](const uvec3& t) {
        const vec3 n = glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
        const float length_sq = glm::dot(n, n);
        return !(length_sq >= FLT_MIN &&
                 length_sq <= FLT_MAX);  // below, its normal is lost in float; NaN is caught too
    };
    return std::erase_if(mesh.triangles, degenerate);
}

}  // namespace photond
