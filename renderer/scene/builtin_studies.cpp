// Small scenes that each show one thing: energy balance, a caustic, light that is hard to find.

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/mesh_builder.h"

namespace photond {

Scene make_furnace() {
    // Inside a closed surface that emits L and reflects a share `albedo` everywhere, radiance is L / (1 - albedo) in
    // every direction, whatever the surface's shape: the facets of the sphere cost no exactness.
    Scene scene;
    Material wall = lambert("wall", Rgb(0.5f));
    wall.emission = Rgb(1);
    Mesh sphere = make_icosphere(3, add_material(scene, wall));
    for (uvec3& t : sphere.triangles) std::swap(t.y, t.z);  // fronts, which emit, look inwards
    add_mesh(scene, std::move(sphere));
    add_camera(scene, dvec3(0), dvec3(0, 0, -1), 1.2f);
    return scene;
}

Scene make_caustic_ring() {
    // A polished ring on a table gathers the lamp's light into a nephroid, the cusped curve seen in every cup.
    Scene scene;
    const uint32_t table = add_material(scene, lambert("table", {0.6f, 0.58f, 0.55f}));
    const uint32_t gold = add_material(scene, metal("gold", {1.0f, 0.78f, 0.34f}, 0));
    const uint32_t lamp = add_material(scene, emitter("lamp", Rgb(130, 124, 112)));
    const uint32_t sky = add_material(scene, emitter("sky panel", Rgb(0.6f, 0.7f, 0.9f)));

    add_mesh(scene, MeshBuilder().quad({-8, 0, 8}, {8, 0, 8}, {8, 0, -8}, {-8, 0, -8}).build(table));
    constexpr float kOuter = 1.06f, kInner = 1.0f, kHeight = 0.55f, kBevel = 0.01f, kLift = 0.001f;
    const vec2 profile[] = {{kInner + kBevel, kLift},   {kOuter - kBevel, kLift},   {kOuter, kLift + kBevel},
                            {kOuter, kHeight - kBevel}, {kOuter - kBevel, kHeight}, {kInner + kBevel, kHeight},
                            {kInner, kHeight - kBevel}, {kInner, kLift + kBevel},   {kInner + kBevel, kLift}};
    add_mesh(scene, MeshBuilder().lathe(profile, 512).build(gold));

    // The lamp: a disc of 0.35 m radius that looks at the ring from the side.
    constexpr uint32_t kSlices = 32;
    const dvec3 at(-4.2, 3.2, -0.6);
    const Camera aim = look_at_camera(at, dvec3(0, 0.2, 0), dvec3(0, 1, 0), 1);
    MeshBuilder disc;
    for (uint32_t i = 0; i < kSlices; ++i) {
        const auto rim = [&](uint32_t k) {
            const float angle = 2 * kPi * static_cast<float>(k % kSlices) / static_cast<float>(kSlices);
            return aim.position + 0.35f * (std::cos(angle) * aim.right + std::sin(angle) * aim.up);
        };
        disc.triangle(aim.position, rim(i + 1), rim(i));
    }
    add_mesh(scene, disc.build(lamp));
    add_mesh(scene, MeshBuilder().quad({-3, 6, -3}, {3, 6, -3}, {3, 6, 3}, {-3, 6, 3}).build(sky));
    add_camera(scene, {1.9, 2.6, 3.1}, {-0.02, 0.12, 0}, 0.6f);
    return scene;
}

namespace {

/// Half the width of the keyhole at a height: a round eye above a slot that widens downwards.
float keyhole_half_width(float y) {
    constexpr float kEyeHeight = 1.45f, kEyeRadius = 0.26f, kSlotBottom = 0.75f, kSlotTop = 0.1f, kSlotFoot = 0.2f;
    float half_width = 0;
    if (y >= kSlotBottom && y <= kEyeHeight)
        half_width = kSlotFoot + (kSlotTop - kSlotFoot) * (y - kSlotBottom) / (kEyeHeight - kSlotBottom);
    const float above = y - kEyeHeight;
    if (std::fabs(above) < kEyeRadius) half_width = std::max(half_width, std::sqrt(sqr(kEyeRadius) - sqr(above)));
    return half_width;
}

}  // namespace

Scene make_keyhole() {
    // Two rooms and a wall with a keyhole between them. The only light is in the far room, beside the line of sight:
    // all that is seen here came through the hole.
    Scene scene;
    const uint32_t plaster = add_material(scene, lambert("plaster", {0.75f, 0.73f, 0.7f}));
    const uint32_t boards = add_material(scene, lambert("boards", {0.5f, 0.36f, 0.24f}));
    const uint32_t door = add_material(scene, lambert("door", {0.36f, 0.44f, 0.5f}));
    const uint32_t clay = add_material(scene, lambert("clay", {0.7f, 0.32f, 0.2f}));
    const uint32_t lamp = add_material(scene, emitter("lamp", Rgb(40, 34, 26)));

    constexpr float kHalf = 2, kHeight = 2.8f, kNear = 4, kFar = -4, kThick = 0.12f;
    constexpr float kFace = kThick / 2;
    MeshBuilder walls, floors;
    for (const auto& [front, back] : {std::pair{kNear, kFace}, std::pair{-kFace, kFar}}) {
        floors.quad({-kHalf, 0, front}, {kHalf, 0, front}, {kHalf, 0, back}, {-kHalf, 0, back});
        walls.quad({-kHalf, kHeight, back}, {kHalf, kHeight, back}, {kHalf, kHeight, front}, {-kHalf, kHeight, front});
        walls.quad({-kHalf, 0, front}, {-kHalf, 0, back}, {-kHalf, kHeight, back}, {-kHalf, kHeight, front});
        walls.quad({kHalf, 0, back}, {kHalf, 0, front}, {kHalf, kHeight, front}, {kHalf, kHeight, back});
    }
    walls.quad({-kHalf, 0, kFar}, {kHalf, 0, kFar}, {kHalf, kHeight, kFar}, {-kHalf, kHeight, kFar});
    walls.quad({kHalf, 0, kNear}, {-kHalf, 0, kNear}, {-kHalf, kHeight, kNear}, {kHalf, kHeight, kNear});

    // The wall between, in level strips cut by the hole's outline.
    constexpr uint32_t kStrips = 140;
    MeshBuilder partition;
    for (uint32_t i = 0; i < kStrips; ++i) {
        const float y0 = kHeight * static_cast<float>(i) / kStrips, y1 = kHeight * static_cast<float>(i + 1) / kStrips;
        const float w0 = keyhole_half_width(y0), w1 = keyhole_half_width(y1);
        for (const float z : {kFace, -kFace}) {
            const float s = z > 0 ? 1.0f : -1.0f;  // left and right as seen from that side
            partition.quad({-s * kHalf, y0, z}, {-s * w0, y0, z}, {-s * w1, y1, z}, {-s * kHalf, y1, z});
            partition.quad({s * w0, y0, z}, {s * kHalf, y0, z}, {s * kHalf, y1, z}, {s * w1, y1, z});
        }
        if (w0 > 0 || w1 > 0) {  // the hole's inside
            partition.quad({-w0, y0, kFace}, {-w0, y0, -kFace}, {-w1, y1, -kFace}, {-w1, y1, kFace});
            partition.quad({w0, y0, -kFace}, {w0, y0, kFace}, {w1, y1, kFace}, {w1, y1, -kFace});
        }
    }

    add_mesh(scene, floors.build(boards));
    add_mesh(scene, walls.build(plaster));
    add_mesh(scene, partition.build(door));
    add_mesh(scene, MeshBuilder().sphere({0.55f, 0.4f, 1.3f}, 0.4f, 64).build(clay));
    add_mesh(scene, MeshBuilder().rounded_box({-1.2f, 0, 1.0f}, {-0.6f, 0.7f, 1.6f}, 0.04f, 4).build(plaster));
    add_mesh(scene, MeshBuilder()
                        .quad({0.2f, kHeight - 0.02f, -2.6f}, {1.6f, kHeight - 0.02f, -2.6f},
                              {1.6f, kHeight - 0.02f, -1.2f}, {0.2f, kHeight - 0.02f, -1.2f})
                        .build(lamp));
    add_camera(scene, {-0.75, 1.6, 3.85}, {0.05, 0.85, 0}, 0.8f);
    return scene;
}

}  // namespace photond
