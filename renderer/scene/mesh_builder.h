#pragma once
// Meshes made in code, for the built-in scenes and for tests: shapes are added one by one, each placed by the transform
// at hand.

#include <glm/gtc/matrix_transform.hpp>
#include <span>

#include "renderer/scene/scene.h"

namespace photond {

/// Collects shapes that share a material. Front sides, and thus normals, point outwards. Lengths in metres.
class MeshBuilder {
public:
    /// Places the shapes added from now on; must keep orientation (positive determinant).
    MeshBuilder& place(const mat4& to_mesh);
    const mat4& placing() const { return placing_; }

    MeshBuilder& triangle(const vec3& a, const vec3& b, const vec3& c);
    /// Corners counter-clockwise seen from the front; cut into (a, b, c) and (a, c, d). Texture coordinates run from
    /// (0, 0) at a over (1, 0) at b to (1, 1) at c, times `uv_scale`.
    MeshBuilder& quad(const vec3& a, const vec3& b, const vec3& c, const vec3& d, vec2 uv_scale = vec2(1));
    MeshBuilder& box(const vec3& min, const vec3& max);
    /// A box with rounded edges and corners: `radius` of the rounding, `steps` quads across each rounded edge.
    MeshBuilder& rounded_box(const vec3& min, const vec3& max, float radius, uint32_t steps);
    /// Surface of revolution about +y: `profile` holds (radius, height), listed upwards for an outside. Smooth within
    /// `crease_angle` [rad] of bend of the profile.
    MeshBuilder& lathe(std::span<const vec2> profile, uint32_t slices, float crease_angle = 0.7f);
    MeshBuilder& sphere(const vec3& centre, float radius, uint32_t slices);
    /// Upright cylinder with both caps.
    MeshBuilder& cylinder(const vec3& base, float radius, float height, uint32_t slices);
    /// Torus about +y: `radius` of its spine, `tube` of its tube.
    MeshBuilder& torus(const vec3& centre, float radius, float tube, uint32_t slices, uint32_t sides);
    /// A pipe of that radius along a polyline, open at both ends.
    MeshBuilder& pipe(std::span<const vec3> path, float radius, uint32_t sides);
    /// Surface through a grid of points, rows x columns, smooth; front where columns x rows (cross product) points to.
    MeshBuilder& grid(std::span<const vec3> points, uint32_t columns, vec2 uv_scale = vec2(1));

    /// The mesh so far. Without smooth shapes it has no normals (flat shading); texture coordinates only when asked
    /// for.
    Mesh build(uint32_t material, bool with_uv = false) const;

private:
    uint32_t add_vertex(const vec3& p, const vec3& n, vec2 uv);

    mat4 placing_{1.0f};
    mat3 normal_placing_{1.0f};
    Mesh mesh_;
    bool smooth_ = false;
};

/// Unit sphere of 20 x 4^levels triangles from an icosahedron, front sides outwards.
Mesh make_icosphere(uint32_t levels, uint32_t material);

}  // namespace photond
