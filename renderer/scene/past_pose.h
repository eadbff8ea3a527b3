#pragma once
// Where the points of a scene's surfaces were at another moment.

#include <map>
#include <optional>
#include <vector>

#include "renderer/scene/scene.h"

namespace photond {

/// The vertices of all that moves, as a scene shows them now, for when it shows another moment.
class PastPose {
public:
    explicit PastPose(const Scene& scene);

    /// Where the triangle was whose corners world_triangle() gives of the scene as it is now. None where its mesh had
    /// other triangles, so that nothing says which of them it was.
    std::optional<TriangleCorners> triangle(const Scene& now, uint32_t instance, uint32_t triangle) const;
    /// Boxes about the meshes that lie otherwise now than they did, as they do and as they did.
    std::vector<Bounds3> moved_bounds(const Scene& now) const;
    uint64_t bytes() const;

private:
    struct Vertices {
        std::vector<vec3> positions;  // in world space less the scene's origin [m]
        std::vector<uvec3> triangles;
    };
    std::map<uint32_t, Vertices> meshes_;  // by their index: those of the scene's rig
};

}  // namespace photond
