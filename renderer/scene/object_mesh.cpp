#include "renderer/scene/object_mesh.h"

#include <algorithm>
#include <atomic>
#include <cfloat>

#include "renderer/core/parallel.h"
#include "renderer/core/rgb.h"

namespace photond {

namespace {

using glm::dmat3;
using glm::dvec4;

constexpr size_t kVerticesAtOnce = 2048;

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

/// A mesh at work. Positions and what goes with them are computed vertex by vertex, each from its own alone.
class MeshPoser {
public:
    MeshPoser(const ObjectMesh& object, const MeshPose& pose, Mesh& posed)
        : object_(object), pose_(pose), posed_(posed) {
        for (const MorphTarget& target : object.targets)
            if (target.weight < pose.weights.size() && pose.weights[target.weight] != 0)
                targets_.push_back({&target, pose.weights[target.weight]});
    }

    /// A mesh in its place already keeps the file's bits.
    bool is_in_place() const {
        return targets_.empty() && object_.joint_sets == 0 && pose_.transforms.front() == dmat4(1) &&
               pose_.origin == dvec3(0);
    }

    bool run() {
        const size_t count = object_.mesh.positions.size();
        posed_.positions.resize(count);
        posed_.normals.resize(object_.mesh.normals.size());
        posed_.tangents.resize(object_.mesh.tangents.size());
        mirrored_.assign(object_.joint_sets > 0 ? count : 1, 0);
        if (object_.joint_sets == 0) mirrored_.front() = glm::determinant(dmat3(pose_.transforms.front())) < 0;
        std::vector<uint8_t> bad(posed_.normals.size(), 0);
        std::atomic<bool> finite = true;
        parallel_for((count + kVerticesAtOnce - 1) / kVerticesAtOnce, 1, [&](size_t chunk) {
            const size_t end = std::min(count, (chunk + 1) * kVerticesAtOnce);
            for (size_t v = chunk * kVerticesAtOnce; v < end; ++v)
                if (!pose_vertex(v, bad)) finite = false;
        });
        if (!finite) return false;
        turn_mirrored_triangles();
        if (std::ranges::find(bad, 1) != bad.end()) replace_normals(posed_, {bad.begin(), bad.end()});
        return true;
    }

private:
    struct Weighed {
        const MorphTarget* target;
        double weight;
    };

    dvec3 displaced(const vec3& stored, std::vector<vec3> MorphTarget::*part, size_t v) const {
        dvec3 sum(stored);
        for (const Weighed& weighed : targets_)
            if (const std::vector<vec3>& offsets = weighed.target->*part; !offsets.empty())
                sum += weighed.weight * dvec3(offsets[v]);
        return sum;
    }

    dmat4 transform_of(size_t v) const {
        const size_t influences = size_t{object_.joint_sets} * 4;
        if (influences == 0) return pose_.transforms.front();
        dmat4 blended(0.0);
        double sum = 0;
        for (size_t k = 0; k < influences; ++k) {
            const JointWeight& influence = object_.influences[v * influences + k];
            if (influence.weight == 0) continue;
            blended += pose_.transforms[influence.joint] * static_cast<double>(influence.weight);
            sum += static_cast<double>(influence.weight);
        }
        return blended / sum;
    }

    bool pose_vertex(size_t v, std::vector<uint8_t>& bad) {
        const Mesh& stored = object_.mesh;
        const dmat4 transform = transform_of(v);
        const dmat3 linear(transform);
        const dvec3 position = displaced(stored.positions[v], &MorphTarget::positions, v);
        posed_.positions[v] = vec3(dvec3(transform * dvec4(position, 1)) - pose_.origin);
        const bool mirrors = object_.joint_sets > 0 ? glm::determinant(linear) < 0 : mirrored_.front() != 0;
        if (object_.joint_sets > 0) mirrored_[v] = mirrors;
        if (!stored.normals.empty()) {
            const dvec3 normal = normal_matrix(linear) * displaced(stored.normals[v], &MorphTarget::normals, v);
            const double length = glm::length(normal);
            bad[v] = !(length > 0) || !std::isfinite(length);
            if (!bad[v]) posed_.normals[v] = vec3(normal / length);
        }
        if (!stored.tangents.empty()) {
            const vec4 tangent = stored.tangents[v];
            posed_.tangents[v] =
                vec4(unit_or(linear * displaced(vec3(tangent), &MorphTarget::tangents, v), vec3(1, 0, 0)),
                     mirrors ? -tangent.w : tangent.w);
        }
        const vec3& p = posed_.positions[v];
        return is_finite(p);
    }

    /// A skinned triangle is mirrored where most of its corners are.
    void turn_mirrored_triangles() {
        posed_.triangles = object_.mesh.triangles;
        const bool skinned = object_.joint_sets > 0;
        if (!skinned && !mirrored_.front()) return;
        for (uvec3& t : posed_.triangles)
            if (!skinned || mirrored_[t.x] + mirrored_[t.y] + mirrored_[t.z] > 1) std::swap(t.y, t.z);
    }

    const ObjectMesh& object_;
    const MeshPose& pose_;
    Mesh& posed_;
    std::vector<Weighed> targets_;   // those that count
    std::vector<uint8_t> mirrored_;  // a vertex, where joints move it; else one of all
};

template <class T>
uint64_t array_bytes(const std::vector<T>& array) {
    return array.capacity() * sizeof(T);
}

}  // namespace

uint64_t ObjectMesh::bytes() const {
    uint64_t bytes = mesh.bytes() + array_bytes(influences) + array_bytes(targets);
    for (const MorphTarget& target : targets)
        bytes += array_bytes(target.positions) + array_bytes(target.normals) + array_bytes(target.tangents);
    return bytes;
}

bool pose_mesh(const ObjectMesh& object, const MeshPose& pose, Mesh& posed) {
    MeshPoser poser(object, pose, posed);
    if (!poser.is_in_place()) {
        if (!poser.run()) return false;
    } else if (&posed != &object.mesh) {
        posed.positions = object.mesh.positions;
        posed.normals = object.mesh.normals;
        posed.tangents = object.mesh.tangents;
        posed.triangles = object.mesh.triangles;
    }
    return true;
}

void replace_normals(Mesh& mesh, const std::vector<bool>& marked) {
    std::vector<dvec3> sum(mesh.positions.size(), dvec3(0));
    for (const uvec3& t : mesh.triangles) {
        const dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
        for (int k = 0; k < 3; ++k) sum[t[k]] += glm::cross(b - a, c - a);
    }
    for (size_t v = 0; v < mesh.positions.size(); ++v)
        if (marked[v]) mesh.normals[v] = unit_or(sum[v], vec3(0, 1, 0));
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
