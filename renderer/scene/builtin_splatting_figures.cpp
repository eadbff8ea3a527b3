// What the figures of the photon splatting thesis show [Hoet 2014, section 5], each in a scene of its own where
// none of the others has it. All light comes from a spot onto the floor: what else is lit is lit indirectly.

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_furniture.h"
#include "renderer/scene/mesh_builder.h"

namespace photond {

namespace {

constexpr Rgb kPlaster{0.7f, 0.7f, 0.68f};

/// The inside of a box without its front (z = max.z).
void add_room(Scene& scene, const vec3& min, const vec3& max) {
    MeshBuilder room;
    room.quad({min.x, min.y, max.z}, {max.x, min.y, max.z}, {max.x, min.y, min.z}, {min.x, min.y, min.z});
    room.quad({min.x, max.y, min.z}, {max.x, max.y, min.z}, {max.x, max.y, max.z}, {min.x, max.y, max.z});
    room.quad({min.x, min.y, min.z}, {max.x, min.y, min.z}, {max.x, max.y, min.z}, {min.x, max.y, min.z});
    room.quad({max.x, min.y, min.z}, {max.x, min.y, max.z}, {max.x, max.y, max.z}, {max.x, max.y, min.z});
    room.quad({min.x, min.y, max.z}, {min.x, min.y, min.z}, {min.x, max.y, min.z}, {min.x, max.y, max.z});
    add_mesh(scene, room.build(add_material(scene, lambert("plaster", kPlaster))));
}

/// A cone of light without a soft rim: its footprint is lit, nothing else.
void add_spot(Scene& scene, const vec3& position, const vec3& target, float half_angle, float intensity) {
    PunctualLight spot;
    spot.name = "spot";
    spot.kind = PunctualLight::Kind::Spot;
    spot.intensity = Rgb(intensity);
    spot.position = position;
    spot.direction = glm::normalize(target - position);
    spot.cos_inner = std::cos(0.95f * half_angle);
    spot.cos_outer = std::cos(half_angle);
    scene.punctual_lights.push_back(spot);
}

}  // namespace

Scene make_splatting_plate() {
    // Figure 14: a plate, as an exit sign, 10 cm off the wall, above the reach of the spot. Each photon's splat carries
    // one sharp shadow of it to the wall; the sum of them is soft.
    Scene scene;
    add_room(scene, {-2, 0, -2}, {2, 2.6f, 2});
    constexpr float kGap = 0.1f, kThickness = 0.02f, kWall = -2;
    add_mesh(scene, MeshBuilder()
                        .box({-0.35f, 1.5f, kWall + kGap}, {0.35f, 1.75f, kWall + kGap + kThickness})
                        .build(add_material(scene, lambert("sign", {0.15f, 0.5f, 0.2f}))));
    add_spot(scene, {0, 2.55f, -0.4f}, {0, 0, -0.4f}, 0.45f, 60);
    add_camera(scene, {0, 1.4, 0.6}, {0, 1.5, -2}, 0.75f);
    return scene;
}

Scene make_splatting_skimming_ray() {
    // Figure 16: light leaves a spot of the floor, skims the top of a partition and meets the wall behind. No ray from
    // there reaches the foot of that wall; a wide frustum that begins behind the partition does.
    Scene scene;
    add_room(scene, {-2, 0, -1.5f}, {2, 2.6f, 1.5f});
    add_mesh(scene, MeshBuilder()
                        .box({0.8f, 0, -1.5f}, {0.9f, 0.9f, 1.5f})
                        .build(add_material(scene, lambert("partition", {0.6f, 0.35f, 0.2f}))));
    add_spot(scene, {-0.9f, 2.55f, 0}, {-0.9f, 0, 0}, 0.25f, 120);
    add_camera(scene, {0.2, 2.35, 1.4}, {1.75, 0.45, -0.5}, 0.95f);
    return scene;
}

Scene make_splatting_chairs() {
    // Figure 19: chairs between a lit spot of the floor and the wall, whose shadows on the wall are indirect ones.
    Scene scene;
    add_room(scene, {-2.4f, 0, -2}, {2.4f, 2.6f, 2.5f});
    MeshBuilder frames, cushions;
    for (const float x : {-1.1f, 0.0f, 1.1f}) {
        const mat4 to_room = glm::translate(mat4(1), vec3(x, 0, -1.35f));
        furniture::add_chair(frames.place(to_room), cushions.place(to_room));
    }
    add_mesh(scene, frames.build(add_material(scene, lambert("frame", {0.35f, 0.22f, 0.12f}))));
    add_mesh(scene, cushions.build(add_material(scene, lambert("cushion", {0.5f, 0.12f, 0.1f}))));
    add_spot(scene, {0, 2.55f, 0.3f}, {0, 0, 0.3f}, 0.3f, 120);
    add_camera(scene, {1.5, 1.5, 2.2}, {-0.1, 0.55, -2}, 0.65f);
    return scene;
}

}  // namespace photond
