// What real rooms have at the foot of a wall and on it: skirting boards, mouldings, bevels, shelves, books. Each stands
// against surfaces that go on behind and below it, as people model them. Density estimation is judged by these scenes:
// sheets that end at one place a few centimetres apart, and floor that no photon comes to.

#include <array>

#include "renderer/core/rng.h"
#include "renderer/scene/builtin_families.h"
#include "renderer/scene/mesh_builder.h"

namespace photond {

namespace {

constexpr float kHalf = 2, kHeight = 2.6f;  // of the room [m]
constexpr float kWall = -kHalf;             // z of the wall that is looked at

/// A room of 4 x 4 m with a lamp below its ceiling, seen from a chair.
Scene make_room() {
    Scene scene;
    const uint32_t plaster = add_material(scene, lambert("plaster", {0.74f, 0.71f, 0.66f}));
    const uint32_t boards = add_material(scene, lambert("boards", {0.5f, 0.38f, 0.28f}));
    const uint32_t lamp = add_material(scene, emitter("lamp", Rgb(17, 15, 12)));
    constexpr float h = kHalf, y = kHeight;
    add_mesh(scene, MeshBuilder().quad({-h, 0, h}, {h, 0, h}, {h, 0, -h}, {-h, 0, -h}).build(boards));
    MeshBuilder walls;
    walls.quad({-h, y, -h}, {h, y, -h}, {h, y, h}, {-h, y, h});
    walls.quad({-h, 0, -h}, {h, 0, -h}, {h, y, -h}, {-h, y, -h});
    walls.quad({h, 0, h}, {-h, 0, h}, {-h, y, h}, {h, y, h});
    walls.quad({-h, 0, h}, {-h, 0, -h}, {-h, y, -h}, {-h, y, h});
    walls.quad({h, 0, -h}, {h, 0, h}, {h, y, h}, {h, y, -h});
    add_mesh(scene, walls.build(plaster));
    constexpr float kLampHalf = 0.4f, kBelow = kHeight - 0.01f;
    add_mesh(scene, MeshBuilder()
                        .quad({-kLampHalf, kBelow, -kLampHalf}, {kLampHalf, kBelow, -kLampHalf},
                              {kLampHalf, kBelow, kLampHalf}, {-kLampHalf, kBelow, kLampHalf})
                        .build(lamp));
    add_camera(scene, {0.3, 0.9, 0.4}, {0, 0.4, kWall}, 0.75f);
    return scene;
}

uint32_t white(Scene& scene) { return add_material(scene, lambert("white paint", {0.8f, 0.8f, 0.78f})); }

/// A box along the foot of the wall, from corner to corner.
MeshBuilder& add_bar(MeshBuilder& builder, float height, float depth, float from = 0) {
    return builder.box({-kHalf, from, kWall}, {kHalf, from + height, kWall + depth});
}

/// A strip along the wall whose cross-section is that line of (distance from the wall, height), listed upwards.
MeshBuilder& add_strip(MeshBuilder& builder, std::span<const vec2> profile) {
    std::vector<vec3> points;
    for (const vec2& p : profile)
        for (const float x : {-kHalf, kHalf}) points.emplace_back(x, p.y, kWall + p.x);
    return builder.grid(points, 2);
}

/// Boards of a shelf that stands before the wall.
constexpr float kShelfHalf = 0.9f, kShelfDepth = 0.28f, kBoard = 0.02f, kShelfRow = 0.3f;
constexpr int kShelfRows = 3;
void add_shelf(Scene& scene) {
    const uint32_t wood = add_material(scene, lambert("wood", {0.62f, 0.47f, 0.32f}));
    MeshBuilder shelf;
    for (int i = 0; i <= kShelfRows; ++i) {
        const float y = kShelfRow * static_cast<float>(i);
        shelf.box({-kShelfHalf, y, kWall}, {kShelfHalf, y + kBoard, kWall + kShelfDepth});
    }
    for (const float s : {-1.0f, 1.0f}) {
        const float inner = s * kShelfHalf, outer = s * (kShelfHalf + kBoard);
        shelf.box({std::min(inner, outer), 0, kWall},
                  {std::max(inner, outer), kShelfRow * kShelfRows + kBoard, kWall + kShelfDepth});
    }
    add_mesh(scene, shelf.build(wood));
}

}  // namespace

Scene make_detail_bar() {
    Scene scene = make_room();
    MeshBuilder bar;
    add_mesh(scene, add_bar(bar, 0.15f, 0.02f).build(white(scene)));
    return scene;
}

Scene make_detail_bar_at_mid_height() {
    Scene scene = make_room();
    MeshBuilder bar;
    add_mesh(scene, add_bar(bar, 0.15f, 0.02f, 0.6f).build(white(scene)));
    return scene;
}

Scene make_detail_stepped_bars() {
    Scene scene = make_room();
    MeshBuilder bars;
    add_bar(bars, 0.15f, 0.02f);
    add_mesh(scene, add_bar(bars, 0.07f, 0.035f).build(white(scene)));
    return scene;
}

Scene make_detail_moulding() {
    // A skirting board with an ogee at its top, and a quarter round at its foot.
    Scene scene = make_room();
    MeshBuilder moulding;
    constexpr int kSteps = 12;
    std::vector<vec2> ogee = {{0.022f, 0}, {0.022f, 0.11f}};
    for (int i = 1; i <= kSteps; ++i) {
        const float t = static_cast<float>(i) / kSteps;
        ogee.emplace_back(0.022f - 0.014f * t - 0.004f * std::sin(2 * kPi * t), 0.11f + 0.03f * t);
    }
    ogee.emplace_back(0.0f, 0.14f);
    add_strip(moulding, ogee);
    std::vector<vec2> quarter;
    for (int i = 0; i <= kSteps; ++i) {
        const float angle = 0.5f * kPi * static_cast<float>(i) / kSteps;
        quarter.emplace_back(0.022f + 0.018f * std::cos(angle), 0.018f * std::sin(angle));
    }
    add_mesh(scene, add_strip(moulding, quarter).build(white(scene)));
    return scene;
}

Scene make_detail_bevel() {
    // A bench and two panels of the wall, all with edges rounded by a centimetre.
    Scene scene = make_room();
    MeshBuilder blocks;
    blocks.rounded_box({-0.8f, -0.02f, kWall + 0.1f}, {0.8f, 0.42f, kWall + 0.5f}, 0.01f, 3);
    for (const float x : {-0.75f, 0.75f})
        blocks.rounded_box({x - 0.6f, 0.6f, kWall - 0.01f}, {x + 0.6f, 1.2f, kWall + 0.02f}, 0.01f, 3);
    add_mesh(scene, blocks.build(white(scene)));
    return scene;
}

Scene make_detail_shelf() {
    Scene scene = make_room();
    add_shelf(scene);
    return scene;
}

Scene make_detail_books() {
    Scene scene = make_room();
    add_shelf(scene);
    constexpr Rgb kColours[] = {{0.55f, 0.2f, 0.16f}, {0.2f, 0.34f, 0.42f}, {0.7f, 0.62f, 0.42f}, {0.28f, 0.4f, 0.24f}};
    RandomStream random(1, RandomDomain::BuiltinScene, 0, 0);
    std::array<MeshBuilder, std::size(kColours)> books;
    for (int row = 0; row < kShelfRows; ++row) {
        const float foot = kShelfRow * static_cast<float>(row) + kBoard;
        for (float x = -kShelfHalf + 0.01f; x < kShelfHalf - 0.1f;) {
            const float thick = 0.015f + 0.03f * random.next(), tall = 0.17f + 0.08f * random.next(),
                        deep = 0.13f + 0.06f * random.next();
            const auto colour = static_cast<size_t>(random.next() * static_cast<float>(books.size()));
            if (random.next() < 0.9f)  // here and there one is missing
                books[std::min(colour, books.size() - 1)].box({x, foot, kWall + 0.03f},
                                                              {x + thick, foot + tall, kWall + 0.03f + deep});
            x += thick + 0.002f;
        }
    }
    for (size_t i = 0; i < books.size(); ++i)
        add_mesh(scene, books[i].build(add_material(scene, lambert("book", kColours[i]))));
    return scene;
}

}  // namespace photond
