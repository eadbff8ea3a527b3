#pragma once
// Pieces that built-in scenes are furnished with. Unless said otherwise, each stands on y = 0 about the origin of its
// own space and looks towards +z; lengths in metres.

#include <span>

#include "renderer/core/rng.h"
#include "renderer/scene/mesh_builder.h"

namespace photond::furniture {

/// Turned by `yaw` [rad] about +y, then moved.
inline mat4 placed(const vec3& at, float yaw = 0) {
    return glm::rotate(glm::translate(mat4(1), at), yaw, vec3(0, 1, 0));
}
/// One more placing of a mesh of the scene.
void add_instance(Scene& scene, uint32_t mesh, const vec3& at, float yaw);

void add_table(MeshBuilder& wood, float width, float depth, float height);
/// A chair whose frame and cushion are of different materials.
void add_chair(MeshBuilder& frame, MeshBuilder& cushion);
void add_sofa(MeshBuilder& cover, MeshBuilder& feet, float width);
/// Shelves of width x height, open in front; the books go into as many builders as there are covers.
void add_bookcase(MeshBuilder& wood, std::span<MeshBuilder> books, float width, float height, RandomStream& random);
/// A hanging cloth in folds, `drop` high, from x = 0 to `width`; its front looks along +z.
void add_curtain(MeshBuilder& cloth, float width, float drop, uint32_t folds, RandomStream& random);
void add_floor_lamp(MeshBuilder& metal, MeshBuilder& shade, MeshBuilder& bulb);
/// A lamp that hangs from y = 0 on a cord of that length; its shell is enamelled inside.
void add_pendant_lamp(MeshBuilder& metal, MeshBuilder& enamel, MeshBuilder& bulb, float cord);
void add_plant(MeshBuilder& pot, MeshBuilder& earth, MeshBuilder& leaves, RandomStream& random);
void add_bowl(MeshBuilder& clay);
void add_vase(MeshBuilder& clay);
void add_plate(MeshBuilder& china);
/// A drinking glass: one closed surface.
void add_tumbler(MeshBuilder& glass);
/// A hollow globe of glass about the origin, for a light within: two closed surfaces. `rings` waves from pole to pole
/// make the glass thicker and thinner by `wave` of its radius.
void add_glass_globe(MeshBuilder& glass, float radius, float wall, uint32_t rings, float wave);
/// The inside of a paraboloid that opens at y = 0 towards +y, `depth` deep. Its focus is radius^2 / (4 depth) above its
/// apex.
void add_reflector(MeshBuilder& mirror, float radius, float depth, uint32_t slices);

}  // namespace photond::furniture
