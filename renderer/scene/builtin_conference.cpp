// A conference room made in code, for methods in real time: a long table and many chairs under recessed lamps, panelled
// walls, a window behind blinds. Light comes to most of it by more than one bounce.

#include "renderer/scene/builtin_families.h"
#include "renderer/scene/builtin_furniture.h"

namespace photond {

namespace {

// The inside: x from -5 (whiteboard) to 5, z from -3.5 (window wall) to 3.5.
constexpr float kLong = 5, kDeep = 3.5f, kHigh = 2.9f;
constexpr float kSill = 1.0f, kLintel = 2.3f, kWindowEnd = 3.4f;
constexpr float kTableHigh = 0.74f, kTableLong = 2.7f, kTableDeep = 0.75f;  // the latter two from the middle

void add_shell(Scene& scene) {
    const uint32_t carpet = add_material(scene, lambert("carpet", {0.13f, 0.15f, 0.2f}));
    const uint32_t plaster = add_material(scene, lambert("plaster", {0.74f, 0.73f, 0.7f}));
    const uint32_t paint = add_material(scene, plastic("window paint", Rgb(0.78f), 0.3f));
    const uint32_t sky = add_material(scene, emitter("sky", Rgb(3.5f, 4.2f, 5)));
    constexpr float x = kLong, z = kDeep, h = kHigh, out = -z - 0.3f;
    add_mesh(scene, MeshBuilder().quad({-x, 0, z}, {x, 0, z}, {x, 0, -z}, {-x, 0, -z}).build(carpet));
    MeshBuilder walls;
    walls.quad({-x, 0, z}, {-x, 0, -z}, {-x, h, -z}, {-x, h, z}).quad({x, 0, -z}, {x, 0, z}, {x, h, z}, {x, h, -z});
    walls.quad({x, 0, z}, {-x, 0, z}, {-x, h, z}, {x, h, z});
    const auto on_window_wall = [&](float x0, float x1, float y0, float y1) {
        walls.quad({x0, y0, -z}, {x1, y0, -z}, {x1, y1, -z}, {x0, y1, -z});
    };
    on_window_wall(-x, x, 0, kSill), on_window_wall(-x, x, kLintel, h);
    on_window_wall(-x, -kWindowEnd, kSill, kLintel), on_window_wall(kWindowEnd, x, kSill, kLintel);
    constexpr float w = kWindowEnd;  // the opening's four inner sides
    walls.quad({-w, kSill, -z}, {w, kSill, -z}, {w, kSill, out}, {-w, kSill, out});
    walls.quad({-w, kLintel, out}, {w, kLintel, out}, {w, kLintel, -z}, {-w, kLintel, -z});
    walls.quad({-w, kSill, -z}, {-w, kSill, out}, {-w, kLintel, out}, {-w, kLintel, -z});
    walls.quad({w, kSill, out}, {w, kSill, -z}, {w, kLintel, -z}, {w, kLintel, out});
    add_mesh(scene, walls.build(plaster));
    MeshBuilder frame;
    for (const float bar : {-w, -w / 3, w / 3, w - 0.06f})
        frame.rounded_box({bar, kSill, out + 0.04f}, {bar + 0.06f, kLintel, out + 0.1f}, 0.008f, 2);
    frame.rounded_box({-w - 0.05f, kSill - 0.03f, -z - 0.02f}, {w + 0.05f, kSill + 0.002f, -z + 0.12f}, 0.01f, 3);
    add_mesh(scene, frame.build(paint));
    add_mesh(scene, MeshBuilder()
                        .quad({-w - 1, kSill - 0.8f, out - 0.4f}, {w + 1, kSill - 0.8f, out - 0.4f},
                              {w + 1, kLintel + 0.8f, out - 0.4f}, {-w - 1, kLintel + 0.8f, out - 0.4f})
                        .build(sky));
}

/// Slats on two cords, half closed.
void add_blinds(Scene& scene) {
    constexpr int kSlats = 26;
    constexpr float kHalfSlat = 0.024f, kTilt = 0.6f;
    MeshBuilder slats;
    for (int i = 0; i < kSlats; ++i) {
        const float y = kSill + 0.05f + (kLintel - kSill - 0.1f) * static_cast<float>(i) / (kSlats - 1);
        slats.place(glm::rotate(glm::translate(mat4(1), vec3(0, y, -kDeep - 0.07f)), kTilt, vec3(1, 0, 0)));
        slats.box({-kWindowEnd + 0.02f, -0.0006f, -kHalfSlat}, {kWindowEnd - 0.02f, 0.0006f, kHalfSlat});
    }
    add_mesh(scene, slats.build(add_material(scene, plastic("slats", {0.75f, 0.74f, 0.7f}, 0.4f))));
}

/// A ceiling of tiles with lamps that lie deeper than it.
void add_ceiling(Scene& scene) {
    constexpr float kHalfLamp = 0.6f, kHalfWidth = 0.15f, kDepth = 0.1f;
    const uint32_t tiles = add_material(scene, lambert("ceiling tiles", Rgb(0.8f)));
    const uint32_t rails = add_material(scene, metal("rails", Rgb(0.7f), 0.35f));
    const uint32_t lamp = add_material(scene, emitter("tube", Rgb(60, 56, 48)));
    MeshBuilder ceiling, inside, light;
    const float xs[] = {-kLong,    -3.0f - kHalfLamp, -3.0f + kHalfLamp, -kHalfLamp,
                        kHalfLamp, 3.0f - kHalfLamp,  3.0f + kHalfLamp,  kLong};
    const float zs[] = {-kDeep, -1.5f - kHalfWidth, -1.5f + kHalfWidth, 1.5f - kHalfWidth, 1.5f + kHalfWidth, kDeep};
    for (size_t i = 0; i + 1 < std::size(xs); ++i)
        for (size_t j = 0; j + 1 < std::size(zs); ++j) {
            const float x0 = xs[i], x1 = xs[i + 1], z0 = zs[j], z1 = zs[j + 1], y0 = kHigh, y1 = kHigh + kDepth;
            if (i % 2 == 0 || j % 2 == 0) {
                ceiling.quad({x0, y0, z0}, {x1, y0, z0}, {x1, y0, z1}, {x0, y0, z1});
                continue;
            }
            inside.quad({x0, y1, z0}, {x1, y1, z0}, {x1, y1, z1}, {x0, y1, z1});
            inside.quad({x0, y0, z0}, {x1, y0, z0}, {x1, y1, z0}, {x0, y1, z0});
            inside.quad({x1, y0, z1}, {x0, y0, z1}, {x0, y1, z1}, {x1, y1, z1});
            inside.quad({x0, y0, z1}, {x0, y0, z0}, {x0, y1, z0}, {x0, y1, z1});
            inside.quad({x1, y0, z0}, {x1, y0, z1}, {x1, y1, z1}, {x1, y1, z0});
            const float middle = 0.5f * (z0 + z1), y = y1 - 0.03f;
            light.quad({x0 + 0.04f, y, middle - 0.03f}, {x1 - 0.04f, y, middle - 0.03f},
                       {x1 - 0.04f, y, middle + 0.03f}, {x0 + 0.04f, y, middle + 0.03f});
        }
    add_mesh(scene, ceiling.build(tiles));
    add_mesh(scene, inside.build(add_material(scene, metal("reflector", Rgb(0.85f), 0.4f))));
    add_mesh(scene, light.build(lamp));
    MeshBuilder bars;
    for (int i = 0; i < 8; ++i) {
        const float x = -kLong + 0.6f + 1.2f * static_cast<float>(i);
        bars.box({x - 0.012f, kHigh - 0.006f, -kDeep}, {x + 0.012f, kHigh, kDeep});
    }
    add_mesh(scene, bars.build(rails));
}

/// Wood along two walls: panels between upright battens, a skirting, a rail at the height of a chair's back.
void add_panelling(Scene& scene, uint32_t wood, uint32_t dark_wood) {
    MeshBuilder panels, battens;
    const auto along = [&](const mat4& placing, float half) {
        panels.place(placing), battens.place(placing);
        panels.box({-half, 0, 0}, {half, 2.2f, 0.012f});
        for (int i = 0; static_cast<float>(i) <= 4 * half; ++i) {
            const float x = 0.5f * static_cast<float>(i) - half;
            battens.rounded_box({x - 0.02f, 0.1f, 0.012f}, {x + 0.02f, 2.2f, 0.03f}, 0.004f, 2);
        }
        battens.box({-half, 0, 0.012f}, {half, 0.1f, 0.028f});
        battens.rounded_box({-half, 0.84f, 0.012f}, {half, 0.92f, 0.045f}, 0.008f, 3);
        battens.rounded_box({-half, 2.2f, 0}, {half, 2.24f, 0.05f}, 0.008f, 3);
    };
    along(furniture::placed({0, 0, kDeep}, kPi), kLong);
    along(furniture::placed({kLong, 0, 0}, -kPi / 2), kDeep);
    add_mesh(scene, panels.build(wood));
    add_mesh(scene, battens.build(dark_wood));
}

void add_table_and_chairs(Scene& scene, uint32_t wood, uint32_t steel) {
    MeshBuilder top, legs;
    top.rounded_box({-kTableLong, kTableHigh - 0.04f, -kTableDeep}, {kTableLong, kTableHigh, kTableDeep}, 0.015f, 4);
    add_mesh(scene, top.build(wood));
    for (const float x : {-1.7f, 0.0f, 1.7f}) {
        legs.rounded_box({x - 0.3f, 0, -0.45f}, {x + 0.3f, 0.03f, 0.45f}, 0.01f, 2);
        legs.cylinder({x, 0.03f, 0}, 0.06f, kTableHigh - 0.07f, 48);
    }
    add_mesh(scene, legs.build(steel));

    MeshBuilder frame, cushion;
    furniture::add_chair(frame, cushion);
    const auto chair = static_cast<uint32_t>(scene.meshes.size());
    scene.meshes.push_back(frame.build(add_material(scene, plastic("black frame", Rgb(0.04f), 0.3f))));
    scene.meshes.push_back(cushion.build(add_material(scene, lambert("upholstery", {0.35f, 0.08f, 0.06f}))));
    RandomStream random(2, RandomDomain::BuiltinScene, 0, 0);  // the same room every time
    const auto seat = [&](float x, float z, float yaw) {
        const vec3 at(x + 0.1f * (random.next() - 0.5f), 0, z + 0.1f * (random.next() - 0.5f));
        const float turn = yaw + 0.4f * (random.next() - 0.5f);
        for (const uint32_t part : {0u, 1u}) furniture::add_instance(scene, chair + part, at, turn);
    };
    for (const float x : {-2.1f, -1.26f, -0.42f, 0.42f, 1.26f, 2.1f})
        seat(x, kTableDeep + 0.28f, kPi), seat(x, -kTableDeep - 0.28f, 0);
    seat(-kTableLong - 0.3f, 0, kPi / 2), seat(kTableLong + 0.3f, 0, -kPi / 2);
}

/// What lies on the table and stands along the walls.
void add_things(Scene& scene, uint32_t wood, uint32_t steel) {
    const uint32_t clear = add_material(scene, glass("clear glass"));
    const uint32_t paper = add_material(scene, lambert("paper", Rgb(0.82f)));
    const uint32_t folder = add_material(scene, plastic("folder", {0.05f, 0.12f, 0.35f}, 0.3f));
    MeshBuilder tumbler, sheets, folders;
    furniture::add_tumbler(tumbler);
    const auto drink = static_cast<uint32_t>(scene.meshes.size());
    scene.meshes.push_back(tumbler.build(clear));
    int place = 0;
    for (const float x : {-2.1f, -1.26f, -0.42f, 0.42f, 1.26f, 2.1f})
        for (const float side : {-1.0f, 1.0f}) {
            furniture::add_instance(scene, drink, {x + 0.24f, kTableHigh + 0.001f, side * 0.42f}, 0);
            MeshBuilder& pile = place % 3 == 0 ? folders : sheets;
            pile.place(
                furniture::placed({x, kTableHigh + 0.001f, side * 0.5f}, 0.15f * static_cast<float>(place++ % 5 - 2)));
            pile.box({-0.105f, 0, -0.15f}, {0.105f, &pile == &folders ? 0.02f : 0.004f, 0.15f});
        }
    add_mesh(scene, sheets.build(paper));
    add_mesh(scene, folders.build(folder));

    MeshBuilder board, rim, cabinet, clay, vase;
    board.quad({-kLong + 0.02f, 0.95f, 1.5f}, {-kLong + 0.02f, 0.95f, -1.5f}, {-kLong + 0.02f, 2.15f, -1.5f},
               {-kLong + 0.02f, 2.15f, 1.5f});
    add_mesh(scene, board.build(add_material(scene, plastic("whiteboard", Rgb(0.85f), 0.1f))));
    for (const float y : {0.93f, 2.15f}) rim.box({-kLong, y, -1.53f}, {-kLong + 0.035f, y + 0.025f, 1.53f});
    for (const float z : {-1.53f, 1.5f}) rim.box({-kLong, 0.95f, z}, {-kLong + 0.035f, 2.15f, z + 0.03f});
    rim.box({-kLong, 0.9f, -1.4f}, {-kLong + 0.1f, 0.915f, 1.4f});  // for chalks
    add_mesh(scene, rim.build(steel));
    cabinet.rounded_box({-3.2f, 0.08f, kDeep - 0.5f}, {-0.6f, 0.8f, kDeep - 0.06f}, 0.008f, 2);
    for (int door = 0; door < 4; ++door) {
        const float x = -3.17f + 0.65f * static_cast<float>(door);
        cabinet.rounded_box({x, 0.11f, kDeep - 0.515f}, {x + 0.6f, 0.77f, kDeep - 0.5f}, 0.004f, 2);
    }
    add_mesh(scene, cabinet.build(wood));
    clay.place(furniture::placed({-2.6f, 0.801f, kDeep - 0.28f}));
    furniture::add_bowl(clay);
    add_mesh(scene, clay.build(add_material(scene, plastic("china", Rgb(0.8f), 0.1f))));
    vase.place(furniture::placed({-1.2f, 0.801f, kDeep - 0.26f}));
    furniture::add_vase(vase);
    add_mesh(scene, vase.build(add_material(scene, plastic("green glaze", {0.05f, 0.22f, 0.12f}, 0.15f))));

    RandomStream random(3, RandomDomain::BuiltinScene, 0, 0);
    MeshBuilder pot, earth, leaves;
    for (const float x : {-4.3f, 4.3f}) {
        const mat4 corner = furniture::placed({x, 0, -kDeep + 0.55f});
        pot.place(corner), earth.place(corner), leaves.place(corner);
        furniture::add_plant(pot, earth, leaves, random);
    }
    add_mesh(scene, pot.build(add_material(scene, lambert("pot", {0.4f, 0.38f, 0.35f}))));
    add_mesh(scene, earth.build(add_material(scene, lambert("earth", {0.06f, 0.04f, 0.03f}))));
    add_mesh(scene, leaves.build(add_material(scene, plastic("leaf", {0.06f, 0.2f, 0.05f}, 0.35f))));
}

}  // namespace

Scene make_conference() {
    Scene scene;
    const uint32_t wood = add_material(scene, plastic("cherry", {0.4f, 0.2f, 0.1f}, 0.3f));
    const uint32_t dark_wood = add_material(scene, plastic("walnut", {0.18f, 0.1f, 0.06f}, 0.35f));
    const uint32_t steel = add_material(scene, metal("steel", Rgb(0.6f), 0.25f));
    add_shell(scene);
    add_blinds(scene);
    add_ceiling(scene);
    add_panelling(scene, wood, dark_wood);
    add_table_and_chairs(scene, wood, steel);
    add_things(scene, wood, steel);
    add_camera(scene, {-4.5, 1.7, -2.1}, {0.4, 0.9, 0.9}, 1.0f);
    return scene;
}

}  // namespace photond
