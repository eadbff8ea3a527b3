#pragma once
// glTF's equations of animation, morph targets and skins, evaluated in double from a file's JSON and bytes by nothing
// of the renderer: what its poses are compared with (glTF 2.0, 3.7.2.2, 3.7.3.3, 3.11 and appendix C).

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

namespace photond::test {

/// A vertex array of one primitive in world space.
struct EvaluatedPrimitive {
    std::vector<glm::dvec3> positions;
    std::vector<glm::dvec3> normals;  // unit; empty where the file has none
    std::vector<uint32_t> indices;    // of triangles, with their corners as the file has them
};

struct EvaluatedScene {
    std::vector<EvaluatedPrimitive> primitives;  // in the order of the nodes that show them, depth first
    std::vector<glm::dmat4> cameras, lights;     // to world, likewise
};

/// At a time of an animation; at rest where there is none. Accessors must not be sparse, primitives are triangles.
EvaluatedScene evaluate_gltf(const std::string& json, const std::vector<uint8_t>& binary,
                             std::optional<size_t> animation, double time_s);

}  // namespace photond::test
