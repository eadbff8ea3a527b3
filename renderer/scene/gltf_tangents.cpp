// Tangents for normal maps where the file has none. The frame follows the texture coordinates as they are looked up,
// KHR_texture_transform included; the shading normal stays the file's.

#include <numeric>
#include <vector>

#include "renderer/scene/gltf_mesh.h"

namespace photond {

namespace {

template <class T>
void unweld_attribute(std::vector<T>& values, const std::vector<uvec3>& triangles) {
    if (values.empty()) return;
    std::vector<T> corners;
    corners.reserve(triangles.size() * 3);
    for (const uvec3& t : triangles) corners.insert(corners.end(), {values[t.x], values[t.y], values[t.z]});
    values = std::move(corners);
}

void unweld(Mesh& mesh) {
    unweld_attribute(mesh.positions, mesh.triangles);
    unweld_attribute(mesh.uv[0], mesh.triangles);
    unweld_attribute(mesh.uv[1], mesh.triangles);
    unweld_attribute(mesh.colors, mesh.triangles);
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) mesh.triangles[i] = uvec3(3 * i, 3 * i + 1, 3 * i + 2);
}

/// Appends a copy of vertex `v`; gives its index.
uint32_t split_vertex(Mesh& mesh, uint32_t v) {
    const auto copy = [v](auto& values) {
        if (values.empty()) return;
        const auto value = values[v];  // push_back may move what it refers to
        values.push_back(value);
    };
    copy(mesh.positions), copy(mesh.normals), copy(mesh.uv[0]), copy(mesh.uv[1]), copy(mesh.colors);
    return static_cast<uint32_t>(mesh.positions.size() - 1);
}

/// Twice the area of a triangle in texture space, signed, and the direction in which u grows, of length proportional to
/// the triangle's area.
struct UvGradient {
    double area;
    dvec3 along_u;
};

UvGradient uv_gradient(const Mesh& mesh, const TextureRef& reference, const uvec3& t) {
    dvec3 p[3];
    double u[3], v[3];
    for (int k = 0; k < 3; ++k) {
        const uint32_t vertex = t[k];
        const dvec3 st(mesh.uv[reference.uv_set][vertex], 1);
        p[k] = dvec3(mesh.positions[vertex]);
        u[k] = glm::dot(dvec3(reference.row_u), st);
        v[k] = glm::dot(dvec3(reference.row_v), st);
    }
    const dvec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
    const double area = (u[1] - u[0]) * (v[2] - v[0]) - (u[2] - u[0]) * (v[1] - v[0]);
    const dvec3 direction = ((v[2] - v[0]) * e1 - (v[1] - v[0]) * e2) * (area < 0 ? -1.0 : 1.0);
    const double length = glm::length(direction);
    if (area == 0 || !(length > 0) || !std::isfinite(length)) return {0, dvec3(0)};
    return {area, direction / length * glm::length(glm::cross(e1, e2))};
}

/// The shading normals point to the other side than the corners' order says.
bool against_its_normals(const Mesh& mesh, const uvec3& t) {
    if (mesh.normals.empty()) return false;
    const vec3 n = glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
    return glm::dot(n, mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z]) < 0;
}

}  // namespace

std::vector<uint32_t> build_tangents(Mesh& mesh, const TextureRef& normal_texture) {
    if (mesh.uv[normal_texture.uv_set].empty()) return {};  // nothing to follow
    std::vector<uint32_t> before(mesh.positions.size());
    std::iota(before.begin(), before.end(), 0u);
    const size_t stored = before.size();
    const bool unwelded = mesh.normals.empty();
    if (unwelded) {
        unweld_attribute(before, mesh.triangles);
        unweld(mesh);
    }

    // A vertex whose triangles wind both ways in texture space is two vertices. glTF's bitangent is
    // cross(normal, tangent) * w and points where v *falls* in the stored image (v runs down, the normal map's green
    // up), so w is the negative of the sign of the area in (u, v).
    std::vector<dvec3> sum(mesh.positions.size(), dvec3(0));
    std::vector<float> sign(mesh.positions.size(), 0);
    std::vector<uint32_t> twin(mesh.positions.size(), 0);  // 0: none; vertex 0 is never a twin
    for (uvec3& t : mesh.triangles) {
        const UvGradient gradient = uv_gradient(mesh, normal_texture, t);
        if (gradient.area == 0) continue;
        float w = gradient.area < 0 ? 1.0f : -1.0f;
        if (against_its_normals(mesh, t)) w = -w;
        for (int k = 0; k < 3; ++k) {
            uint32_t v = t[k];
            if (sign[v] == 0) sign[v] = w;
            if (sign[v] != w) {
                if (twin[v] == 0) {
                    const uint32_t copy = split_vertex(mesh, v);
                    twin[v] = copy;
                    sum.emplace_back(0.0);
                    sign.push_back(w);
                    twin.push_back(0);
                    before.push_back(before[v]);
                }
                v = t[k] = twin[v];
            }
            sum[v] += gradient.along_u;
        }
    }
    std::vector<vec3> flat;  // per vertex, of a mesh without normals, after unweld()
    if (mesh.normals.empty()) {
        flat.resize(mesh.positions.size(), vec3(0, 1, 0));
        for (const uvec3& t : mesh.triangles) {
            const vec3 n = glm::normalize(
                glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
            for (int k = 0; k < 3; ++k) flat[t[k]] = n;
        }
    }
    const std::vector<vec3>& normals = mesh.normals.empty() ? flat : mesh.normals;
    mesh.tangents.resize(mesh.positions.size());
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        const dvec3 n(normals[v]);
        const dvec3 tangent = sum[v] - glm::dot(sum[v], n) * n;
        const double length = glm::length(tangent);
        // Where the coordinates say nothing, any direction in the surface will do.
        const vec3 unit =
            length > 1e-12 * glm::length(sum[v]) && length > 0 ? vec3(tangent / length) : Frame(normals[v]).tangent;
        mesh.tangents[v] = vec4(unit, sign[v] == 0 ? 1.0f : sign[v]);
    }
    if (!unwelded && before.size() == stored) before.clear();
    return before;
}

void build_tangents(ObjectMesh& object, const TextureRef& normal_texture) {
    const std::vector<uint32_t> before = build_tangents(object.mesh, normal_texture);
    if (before.empty()) return;
    const auto follow = [&](auto& array, size_t width) {
        if (array.empty()) return;
        const auto stored = std::move(array);
        array = {};
        array.reserve(before.size() * width);
        for (const uint32_t v : before)
            for (size_t k = 0; k < width; ++k) array.push_back(stored[v * width + k]);
    };
    follow(object.influences, size_t{object.joint_sets} * 4);
    for (MorphTarget& target : object.targets) {
        follow(target.positions, 1), follow(target.normals, 1);
        target.tangents = {};
    }
}

}  // namespace photond
