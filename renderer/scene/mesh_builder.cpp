#include "renderer/scene/mesh_builder.h"

#include <cassert>
#include <map>

namespace photond {

namespace {

constexpr float kTwoPi = 2 * kPi;

vec3 on_circle(float radius, float height, float turn) {
    // Counter-clockwise seen from above: x to -z, so that (turn, height) is a right-handed surface facing outwards.
    return {radius * std::cos(kTwoPi * turn), height, -radius * std::sin(kTwoPi * turn)};
}

}  // namespace

MeshBuilder& MeshBuilder::place(const mat4& to_mesh) {
    placing_ = to_mesh;
    normal_placing_ = glm::transpose(glm::inverse(mat3(to_mesh)));
    assert(glm::determinant(mat3(to_mesh)) > 0 && "a placing must keep orientation");
    return *this;
}

uint32_t MeshBuilder::add_vertex(const vec3& p, const vec3& n, vec2 uv) {
    mesh_.positions.push_back(vec3(placing_ * vec4(p, 1)));
    mesh_.normals.push_back(glm::normalize(normal_placing_ * n));
    mesh_.uv[0].push_back(uv);
    return static_cast<uint32_t>(mesh_.positions.size() - 1);
}

MeshBuilder& MeshBuilder::triangle(const vec3& a, const vec3& b, const vec3& c) {
    const vec3 n = glm::cross(b - a, c - a);
    const uint32_t first = add_vertex(a, n, {0, 0});
    add_vertex(b, n, {1, 0}), add_vertex(c, n, {1, 1});
    mesh_.triangles.emplace_back(first, first + 1, first + 2);
    return *this;
}

MeshBuilder& MeshBuilder::quad(const vec3& a, const vec3& b, const vec3& c, const vec3& d, vec2 uv_scale) {
    const vec3 n = glm::cross(c - a, d - b);
    const uint32_t first = add_vertex(a, n, {0, 0});
    add_vertex(b, n, {uv_scale.x, 0}), add_vertex(c, n, uv_scale), add_vertex(d, n, {0, uv_scale.y});
    mesh_.triangles.emplace_back(first, first + 1, first + 2);
    mesh_.triangles.emplace_back(first, first + 2, first + 3);
    return *this;
}

MeshBuilder& MeshBuilder::box(const vec3& min, const vec3& max) {
    const auto corner = [&](int x, int y, int z) {
        return vec3(x ? max.x : min.x, y ? max.y : min.y, z ? max.z : min.z);
    };
    quad(corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1));  // +z
    quad(corner(1, 0, 0), corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0));  // -z
    quad(corner(1, 0, 1), corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1));  // +x
    quad(corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0));  // -x
    quad(corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0), corner(0, 1, 0));  // +y
    quad(corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1));  // -y
    return *this;
}

MeshBuilder& MeshBuilder::rounded_box(const vec3& min, const vec3& max, float radius, uint32_t steps) {
    // Each face of a cube, cut finer in its rim, is moved onto the box shrunk by `radius` and then out along the
    // normal.
    assert(steps > 0 && radius > 0);
    smooth_ = true;
    const vec3 centre = 0.5f * (min + max), core = 0.5f * (max - min) - vec3(radius);
    assert(core.x >= 0 && core.y >= 0 && core.z >= 0 && "the rounding must fit into the box");
    const uint32_t columns = 2 * steps + 2;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2;
        const float side = face % 2 ? -1.0f : 1.0f;
        vec3 w(0), s(0), t(0);
        w[axis] = side;
        s[(axis + 1) % 3] = 1;
        t = glm::cross(w, s);
        const auto angle_tangent = [&](uint32_t i) {  // -1 .. 1 over the rounded rim, the flat part in the middle step
            const uint32_t k = i <= steps ? i : i - 1;
            return std::tan(kPi / 4 * (static_cast<float>(k) / static_cast<float>(steps) - 1));
        };
        const uint32_t first = static_cast<uint32_t>(mesh_.positions.size());
        for (uint32_t j = 0; j < columns; ++j)
            for (uint32_t i = 0; i < columns; ++i) {
                const vec3 n = glm::normalize(w + angle_tangent(i) * s + angle_tangent(j) * t);
                const vec3 towards = w + (i <= steps ? -1.0f : 1.0f) * s + (j <= steps ? -1.0f : 1.0f) * t;
                add_vertex(centre + towards * core + radius * n, n,
                           {static_cast<float>(i) / static_cast<float>(columns - 1),
                            static_cast<float>(j) / static_cast<float>(columns - 1)});
            }
        for (uint32_t j = 0; j + 1 < columns; ++j)
            for (uint32_t i = 0; i + 1 < columns; ++i) {
                const uint32_t a = first + j * columns + i, b = a + 1, c = b + columns, d = a + columns;
                mesh_.triangles.emplace_back(a, b, c);
                mesh_.triangles.emplace_back(a, c, d);
            }
    }
    return *this;
}

MeshBuilder& MeshBuilder::lathe(std::span<const vec2> profile, uint32_t slices, float crease_angle) {
    assert(profile.size() >= 2 && slices >= 3);
    smooth_ = true;
    // Normal of a segment in the (radius, height) plane, outwards where the profile runs upwards.
    const auto segment_normal = [&](size_t s) {
        const vec2 along = glm::normalize(profile[s + 1] - profile[s]);
        return vec2(along.y, -along.x);
    };
    const size_t segments = profile.size() - 1;
    for (size_t s = 0; s < segments; ++s) {
        const vec2 own = segment_normal(s);
        const auto blend = [&](size_t other) {
            const vec2 n = segment_normal(other);
            return glm::dot(n, own) > std::cos(crease_angle) ? glm::normalize(n + own) : own;
        };
        const vec2 low = s > 0 ? blend(s - 1) : own, high = s + 1 < segments ? blend(s + 1) : own;
        const uint32_t first = static_cast<uint32_t>(mesh_.positions.size());
        for (uint32_t i = 0; i <= slices; ++i) {
            const float u = static_cast<float>(i) / static_cast<float>(slices);
            const float turn = i == slices ? 0.0f : u;  // the last slice ends exactly where the first begins
            for (int end = 0; end < 2; ++end) {
                const vec2 point = profile[s + static_cast<size_t>(end)], n = end ? high : low;
                add_vertex(on_circle(point.x, point.y, turn), on_circle(n.x, n.y, turn),
                           {u, static_cast<float>(s + static_cast<size_t>(end)) / static_cast<float>(segments)});
            }
        }
        for (uint32_t i = 0; i < slices; ++i) {
            const uint32_t a = first + 2 * i;
            if (profile[s].x > 0) mesh_.triangles.emplace_back(a, a + 2, a + 1);
            if (profile[s + 1].x > 0) mesh_.triangles.emplace_back(a + 1, a + 2, a + 3);
        }
    }
    return *this;
}

MeshBuilder& MeshBuilder::sphere(const vec3& centre, float radius, uint32_t slices) {
    std::vector<vec2> profile;
    const uint32_t stacks = slices / 2;
    for (uint32_t i = 0; i <= stacks; ++i) {
        const float angle = kPi * static_cast<float>(i) / static_cast<float>(stacks);
        profile.emplace_back(i == 0 || i == stacks ? 0.0f : radius * std::sin(angle), -radius * std::cos(angle));
    }
    const size_t first = mesh_.positions.size();
    const mat4 outer = placing_;
    place(glm::translate(outer, centre)).lathe(profile, slices);
    // The exact normals instead of the profile's blended ones.
    const vec3 middle = vec3(placing_ * vec4(0, 0, 0, 1));
    const mat3 to_unit = glm::inverse(mat3(placing_));
    for (size_t i = first; i < mesh_.positions.size(); ++i)
        mesh_.normals[i] = glm::normalize(normal_placing_ * (to_unit * (mesh_.positions[i] - middle)));
    return place(outer);
}

MeshBuilder& MeshBuilder::cylinder(const vec3& base, float radius, float height, uint32_t slices) {
    const vec2 profile[] = {{0, 0}, {radius, 0}, {radius, height}, {0, height}};
    const mat4 outer = placing_;
    return place(glm::translate(outer, base)).lathe(profile, slices).place(outer);
}

MeshBuilder& MeshBuilder::torus(const vec3& centre, float radius, float tube, uint32_t slices, uint32_t sides) {
    std::vector<vec2> profile;
    for (uint32_t i = 0; i <= sides; ++i) {
        const float angle = kTwoPi * static_cast<float>(i % sides) / static_cast<float>(sides);
        profile.emplace_back(radius + tube * std::cos(angle), tube * std::sin(angle));
    }
    const mat4 outer = placing_;
    return place(glm::translate(outer, centre)).lathe(profile, slices, kPi).place(outer);
}

MeshBuilder& MeshBuilder::pipe(std::span<const vec3> path, float radius, uint32_t sides) {
    assert(path.size() >= 2 && sides >= 3);
    smooth_ = true;
    const uint32_t first = static_cast<uint32_t>(mesh_.positions.size());
    vec3 across(0);
    for (size_t i = 0; i < path.size(); ++i) {
        const vec3 tangent = glm::normalize(path[std::min(i + 1, path.size() - 1)] - path[i > 0 ? i - 1 : 0]);
        // Carried along without twist: the last ring's direction, made perpendicular again.
        across = i == 0 ? Frame(tangent).tangent : glm::normalize(across - glm::dot(across, tangent) * tangent);
        const vec3 up = glm::cross(tangent, across);
        for (uint32_t s = 0; s <= sides; ++s) {
            const float u = static_cast<float>(s) / static_cast<float>(sides);
            const float turn = s == sides ? 0.0f : u;
            const vec3 n = std::cos(kTwoPi * turn) * across + std::sin(kTwoPi * turn) * up;
            add_vertex(path[i] + radius * n, n, {u, static_cast<float>(i) / static_cast<float>(path.size() - 1)});
        }
    }
    for (uint32_t i = 0; i + 1 < path.size(); ++i)
        for (uint32_t s = 0; s < sides; ++s) {
            const uint32_t a = first + i * (sides + 1) + s, b = a + 1, c = b + sides + 1, d = a + sides + 1;
            mesh_.triangles.emplace_back(a, b, c);
            mesh_.triangles.emplace_back(a, c, d);
        }
    return *this;
}

MeshBuilder& MeshBuilder::grid(std::span<const vec3> points, uint32_t columns, vec2 uv_scale) {
    assert(columns >= 2 && points.size() % columns == 0 && points.size() / columns >= 2);
    smooth_ = true;
    const uint32_t rows = static_cast<uint32_t>(points.size() / columns);
    const auto at = [&](uint32_t row, uint32_t column) { return points[size_t{row} * columns + column]; };
    const uint32_t first = static_cast<uint32_t>(mesh_.positions.size());
    for (uint32_t r = 0; r < rows; ++r)
        for (uint32_t c = 0; c < columns; ++c) {
            const vec3 s = at(r, std::min(c + 1, columns - 1)) - at(r, c > 0 ? c - 1 : 0);
            const vec3 t = at(std::min(r + 1, rows - 1), c) - at(r > 0 ? r - 1 : 0, c);
            add_vertex(at(r, c), glm::cross(s, t),
                       uv_scale * vec2(static_cast<float>(c) / static_cast<float>(columns - 1),
                                       static_cast<float>(r) / static_cast<float>(rows - 1)));
        }
    for (uint32_t r = 0; r + 1 < rows; ++r)
        for (uint32_t c = 0; c + 1 < columns; ++c) {
            const uint32_t a = first + r * columns + c, b = a + 1, d = a + columns;
            mesh_.triangles.emplace_back(a, b, d + 1);
            mesh_.triangles.emplace_back(a, d + 1, d);
        }
    return *this;
}

Mesh MeshBuilder::build(uint32_t material, bool with_uv) const {
    Mesh mesh;
    mesh.positions = mesh_.positions;  // copies, so that no spare capacity is kept
    mesh.triangles = mesh_.triangles;
    if (smooth_) mesh.normals = mesh_.normals;
    if (with_uv) mesh.uv[0] = mesh_.uv[0];
    mesh.material = material;
    return mesh;
}

Mesh make_icosphere(uint32_t levels, uint32_t material) {
    const float g = 0.5f * (1 + std::sqrt(5.0f));  // golden ratio
    std::vector<vec3> points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                                {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
    for (vec3& p : points) p = glm::normalize(p);
    std::vector<uvec3> faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                                {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                                {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (uint32_t level = 0; level < levels; ++level) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> midpoints;
        const auto midpoint = [&](uint32_t a, uint32_t b) {
            const auto [place, added] =
                midpoints.try_emplace(std::minmax({a, b}), static_cast<uint32_t>(points.size()));
            if (added) points.push_back(glm::normalize(points[a] + points[b]));
            return place->second;
        };
        std::vector<uvec3> finer;
        for (const uvec3& f : faces) {
            const uint32_t ab = midpoint(f.x, f.y), bc = midpoint(f.y, f.z), ca = midpoint(f.z, f.x);
            finer.emplace_back(f.x, ab, ca), finer.emplace_back(f.y, bc, ab);
            finer.emplace_back(f.z, ca, bc), finer.emplace_back(ab, bc, ca);
        }
        faces = std::move(finer);
    }
    Mesh mesh;
    mesh.positions.assign(points.begin(), points.end());
    mesh.triangles.assign(faces.begin(), faces.end());
    mesh.material = material;
    return mesh;
}

}  // namespace photond
