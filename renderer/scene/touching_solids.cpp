#include "renderer/scene/touching_solids.h"

#include <algorithm>
#include <map>

#include "renderer/core/rgb.h"
#include "renderer/scene/box_tree.h"
#include "renderer/scene/scene.h"

namespace photond {

namespace {

constexpr float kOverlap = 4;         // of what rays start off: two faces, and room for rounding
constexpr float kFacing = 1 - 1e-5f;  // cosine between normals that are opposite
constexpr float kSameBend = 0.7f;     // cosine between normals of one bent face; a side face has less
constexpr float kInset = 1e-3f;       // of a triangle's size: less is an edge in common, not a face

/// A triangle in world space with its outward normal.
struct Face {
    vec3 corners[3];
    vec3 normal;
    float size;  // longest edge

    Bounds3 bounds() const {
        Bounds3 box;
        for (const vec3& corner : corners) box.extend(corner);
        return box;
    }
};

/// A solid where it is placed.
struct Solid {
    uint32_t instance;
    bool movable;  // its mesh is placed once
    std::vector<Face> faces;
    std::vector<Bounds3> boxes;  // of the faces
    Bounds3 bounds;
};

/// By how much rays start off, at most, anywhere in the box: offset_ray_origin() moves each coordinate by 2^-16 or by
/// 256 steps of a float, which are up to 2^-15 of it.
float most_offset(const Bounds3& box) {
    const float farthest = std::max(max_component(glm::abs(box.min)), max_component(glm::abs(box.max)));
    return std::max(1.0f / 65536, farthest / 32768);
}

Bounds3 grown(Bounds3 box, float by) {
    box.min -= by, box.max += by;
    return box;
}

std::vector<Solid> find_solids(const Scene& scene) {
    std::vector<uint32_t> placings(scene.meshes.size());
    for (const Instance& instance : scene.instances) ++placings[instance.mesh];
    std::vector<Solid> solids;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
        const Material& material = scene.materials[mesh.material];
        if (!material.solid || !(material.transmission > 0) || material.unlit) continue;
        Solid solid{i, placings[scene.instances[i].mesh] == 1, {}, {}, {}};
        for (const vec3& p : mesh.positions)
            solid.bounds.extend(scene.instances[i].identity ? p : scene.instances[i].to_world * vec4(p, 1));
        solids.push_back(std::move(solid));
    }
    return solids;
}

/// Degenerate triangles have no plane and get normal 0, which faces nothing.
void find_faces(const Scene& scene, Solid& solid) {
    if (!solid.faces.empty()) return;
    const Instance& instance = scene.instances[solid.instance];
    const uint32_t count = static_cast<uint32_t>(scene.meshes[instance.mesh].triangles.size());
    for (uint32_t k = 0; k < count; ++k) {
        const TriangleCorners c = world_triangle(scene, solid.instance, k);
        Face face{{c.p[0], c.p[1], c.p[2]}, vec3(0), 0};
        const dvec3 across = glm::cross(dvec3(c.p[1]) - dvec3(c.p[0]), dvec3(c.p[2]) - dvec3(c.p[0]));
        if (const double length = glm::length(across); length > 0)
            face.normal = vec3((instance.flips_orientation ? -1.0 : 1.0) / length * across);
        for (int i = 0; i < 3; ++i) face.size = std::max(face.size, glm::distance(c.p[i], c.p[(i + 1) % 3]));
        solid.boxes.push_back(face.bounds());
        solid.faces.push_back(face);
    }
}

/// Whether the triangles share an area when seen along their common normal: no line along an edge parts them.
bool overlap_in_plane(const Face& a, const Face& b) {
    const float inset = kInset * std::min(a.size, b.size);
    for (const Face* face : {&a, &b})
        for (int i = 0; i < 3; ++i) {
            const vec3 edge = face->corners[(i + 1) % 3] - face->corners[i];
            const vec3 across = glm::normalize(glm::cross(edge, face->normal));
            float low_a = kInfinity, high_a = -kInfinity, low_b = kInfinity, high_b = -kInfinity;
            for (int k = 0; k < 3; ++k) {
                const float at_a = glm::dot(a.corners[k] - face->corners[i], across);
                const float at_b = glm::dot(b.corners[k] - face->corners[i], across);
                low_a = std::min(low_a, at_a), high_a = std::max(high_a, at_a);
                low_b = std::min(low_b, at_b), high_b = std::max(high_b, at_b);
            }
            if (std::min(high_a, high_b) - std::max(low_a, low_b) <= inset) return false;
        }
    return true;
}

bool touch(const Face& a, const Face& b, float distance) {
    if (!(glm::dot(a.normal, b.normal) < -kFacing)) return false;
    for (int k = 0; k < 3; ++k) {
        const bool near = std::fabs(glm::dot(b.corners[k] - a.corners[0], a.normal)) <= distance ||
                          std::fabs(glm::dot(a.corners[k] - b.corners[0], b.normal)) <= distance;
        if (!near) return false;
    }
    return overlap_in_plane(a, b);
}

struct PlaceOrder {
    bool operator()(const vec3& a, const vec3& b) const {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    }
};

/// Which faces of a solid touch another one, and how far off rays start there.
struct Contact {
    std::vector<bool> touching;  // by face
    float offset = 0;
};

/// The shift, in steps of the overlap, that takes a corner of touching faces (`out`) forward and its other faces back:
/// each normal's equation, all by least squares.
vec3 corner_shift(const std::vector<vec3>& out, const std::vector<vec3>& sides) {
    glm::dmat3 normal_matrix(1e-9);
    dvec3 right(0);
    const auto add = [&](const vec3& normal, double forward) {
        normal_matrix += glm::outerProduct(dvec3(normal), dvec3(normal));
        right += forward * dvec3(normal);
    };
    for (const vec3& normal : out) add(normal, 1);
    for (const vec3& normal : sides) add(normal, -1);
    return vec3(glm::inverse(normal_matrix) * right);
}

void move_faces(Scene& scene, const Solid& solid, const Contact& contact) {
    const Instance& instance = scene.instances[solid.instance];
    Mesh& mesh = scene.meshes[instance.mesh];
    struct Corner {
        std::vector<vec3> out, others;
    };
    std::map<vec3, Corner, PlaceOrder> corners;  // by place in the mesh
    for (size_t k = 0; k < solid.faces.size(); ++k)
        for (int i = 0; i < 3; ++i)
            if (contact.touching[k]) corners[mesh.positions[mesh.triangles[k][i]]].out.push_back(solid.faces[k].normal);
    for (size_t k = 0; k < solid.faces.size(); ++k)
        for (int i = 0; i < 3; ++i)
            if (const auto found = corners.find(mesh.positions[mesh.triangles[k][i]]);
                found != corners.end() && !contact.touching[k])
                found->second.others.push_back(solid.faces[k].normal);
    const glm::dmat3 to_local =
        instance.identity ? glm::dmat3(1) : glm::inverse(glm::dmat3(glm::mat3(instance.to_world)));
    for (vec3& position : mesh.positions) {
        const auto found = corners.find(position);
        if (found == corners.end()) continue;
        std::vector<vec3> sides;
        for (const vec3& other : found->second.others)
            if (std::none_of(found->second.out.begin(), found->second.out.end(),
                             [&](const vec3& out) { return glm::dot(out, other) > kSameBend; }))
                sides.push_back(other);
        const vec3 shift = kOverlap * contact.offset * corner_shift(found->second.out, sides);
        position += vec3(to_local * dvec3(shift));
    }
}

/// Marks what of `mover` touches `still`.
bool find_contact(const Solid& mover, const Solid& still, Contact& contact) {
    const float offset = most_offset(mover.bounds);
    const BoxTree tree(still.boxes);
    bool found = false;
    for (size_t k = 0; k < mover.faces.size(); ++k)
        tree.for_each(grown(mover.boxes[k], offset), [&](uint32_t other) {
            if (!touch(mover.faces[k], still.faces[other], offset)) return;
            contact.touching.resize(mover.faces.size());
            contact.touching[k] = found = true;
        });
    if (found) contact.offset = offset;
    return found;
}

bool intersect(const Bounds3& a, const Bounds3& b) {
    return glm::all(glm::lessThanEqual(a.min, b.max)) && glm::all(glm::lessThanEqual(b.min, a.max));
}

}  // namespace

uint32_t overlap_touching_solids(Scene& scene) {
    std::vector<Solid> solids = find_solids(scene);
    std::vector<Contact> contacts(solids.size());
    uint32_t stuck = 0;
    for (size_t i = 0; i < solids.size(); ++i)
        for (size_t j = 0; j < i; ++j) {
            if (!intersect(grown(solids[i].bounds, most_offset(solids[i].bounds)), solids[j].bounds)) continue;
            find_faces(scene, solids[i]), find_faces(scene, solids[j]);
            const size_t mover = solids[i].movable || !solids[j].movable ? i : j, still = i + j - mover;
            Contact unused;
            Contact& contact = solids[mover].movable ? contacts[mover] : unused;
            if (find_contact(solids[mover], solids[still], contact) && !solids[mover].movable) ++stuck;
        }
    uint32_t changed = 0;
    for (size_t i = 0; i < solids.size(); ++i) {
        if (contacts[i].touching.empty()) continue;
        move_faces(scene, solids[i], contacts[i]);
        ++changed;
    }
    const std::string stuck_text =
        " pairs of touching solids are placed more than once each: light that passes from one to the other meets one "
        "of "
        "their faces only";
    const auto says_so = [&](const std::string& warning) { return warning.ends_with(stuck_text); };
    if (stuck > 0 && std::none_of(scene.warnings.begin(), scene.warnings.end(), says_so))
        scene.warnings.push_back(std::to_string(stuck) + stuck_text);
    return changed;
}

}  // namespace photond
